"""Paints docs/images/conditions.jpg: every condition at its worst level, as the camera sees it.

`python scripts/conditions_picture.py`; IGPF follows the same object in all of them, and its outline
is drawn where it has one. Of the depth sensors' conditions the left half is the depth image.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from experiments.belt.cell import make_cell
from experiments.belt.config import TrialConfig
from experiments.belt.loop import Loop
from experiments.belt.recorder import camera_view
from sim.imaging.degradations import DEGRADATIONS, NORMAL

TARGET = Path(__file__).resolve().parent.parent / "docs" / "images" / "conditions.jpg"
SETTING = TrialConfig(speed_mps=0.25, seed=3)
MOMENT_S = 1.2
"""The hand follows, and the light of `switch` is down."""
INVISIBLE = ("drops", "late")
DEPTH = ("depth", "kinect")
COLUMNS = 3
TILE_PX = 320, 180
"""Width and height."""
BELT = 0.14, 0.89
"""Part of the image's height that shows it."""
DEPTH_RANGE_M = 0.9, 1.5


def main() -> None:
    """Paints the picture."""
    names = [n for n in DEGRADATIONS if n not in INVISIBLE]
    conditions = [NORMAL, *(f"{name}-{len(DEGRADATIONS[name].levels)}" for name in names)]
    views = {name: replace(SETTING, condition=name) for name in conditions}
    views["overhead"] = replace(SETTING, camera="overhead")
    views["turntable"] = replace(SETTING, motion="turntable")
    tiles = [_tile(name, config) for name, config in views.items()]
    rows = [np.hstack(tiles[k : k + COLUMNS]) for k in range(0, len(tiles), COLUMNS)]
    picture = cv2.cvtColor(np.vstack(rows), cv2.COLOR_RGB2BGR)
    cv2.imwrite(str(TARGET), picture, [cv2.IMWRITE_JPEG_QUALITY, 85])
    print(f"{TARGET.relative_to(TARGET.parents[2])}: {', '.join(views)}")


def _tile(name: str, config: TrialConfig) -> np.ndarray:
    """The belt and the outline at MOMENT_S; rows of TILE_PX, the name on the lower rim."""
    loop = Loop(config, make_cell(config, has_camera=True))
    while loop.time_s < MOMENT_S:
        loop.step()
    assert loop.image is not None
    view = camera_view(loop, name)
    if name.startswith(DEPTH):
        middle = view.shape[1] // 2
        view[:, :middle] = _painted(loop.image.whole[1])[:, :middle]
    rows = slice(*(round(part * len(view)) for part in BELT))
    tile = cv2.resize(view[rows], TILE_PX, interpolation=cv2.INTER_AREA)
    tile[-24:] //= 3
    cv2.putText(tile, name, (8, TILE_PX[1] - 8), 0, 0.5, (255, 255, 255), 1, cv2.LINE_AA)
    return cv2.copyMakeBorder(tile, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=(255,) * 3)


def _painted(depth_m: np.ndarray) -> np.ndarray:
    """(h, w, 3) uint8 colours of a depth image; black where there is none."""
    near_m, far_m = DEPTH_RANGE_M
    grey = np.clip((far_m - np.nan_to_num(depth_m, nan=far_m)) / (far_m - near_m), 0.0, 1.0)
    colours = cv2.applyColorMap(np.rint(255 * grey).astype(np.uint8), cv2.COLORMAP_VIRIDIS)
    colours[~(np.isfinite(depth_m) & (depth_m > 0.0))] = 0
    return colours[..., ::-1]


if __name__ == "__main__":
    main()
