"""Paints docs/images/: one attempt in four moments each, camera above, cell below.

python scripts/readme_picture.py [NAME]
"""

from __future__ import annotations

import sys
from pathlib import Path

import cv2
import numpy as np

from experiments.belt.cell import make_cell
from experiments.belt.config import TrialConfig
from experiments.belt.loop import Loop
from experiments.belt.recorder import camera_view, cell_view
from sim.arm.grasp import Phase

PICTURES = {
    "grasp": TrialConfig(speed_mps=0.5, seed=1),
    "real-cell": TrialConfig(
        embodiment="ur3-soft", camera="kinect", condition="kinect-1", speed_mps=0.25, seed=1
    ),
}
MOMENTS = ((Phase.TRACK, 0.05), (Phase.DESCEND, 0.02), (Phase.CLOSE, 0.12), (Phase.HOLD, 0.3))
"""Phases, and how long after their beginning [s]."""
FOLDER = Path(__file__).parents[1] / "docs" / "images"
WIDTH_PX = 400


def main() -> None:
    """Writes the named pictures, or all."""
    for name in sys.argv[1:] or PICTURES:
        paint(PICTURES[name], FOLDER / f"{name}.jpg")


def paint(config: TrialConfig, path: Path) -> None:
    """Runs the attempt and writes the picture."""
    loop, columns = Loop(config, make_cell(config, has_camera=True)), []
    while loop.is_running and len(columns) < len(MOMENTS):
        loop.step()
        phase, after_s = MOMENTS[len(columns)]
        if loop.time_s >= loop.grasp.entered_s.get(phase, np.inf) + after_s:
            camera, cell = camera_view(loop, "camera"), cell_view(loop)
            height_px = len(camera)
            views = [camera[: round(0.708 * height_px)], cell[round(0.208 * height_px) :]]
            columns.append(np.vstack([_small(view) for view in views]))
    cv2.imwrite(str(path), np.hstack(columns)[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 88])
    print(path)


def _small(view: np.ndarray) -> np.ndarray:
    height_px = round(view.shape[0] * WIDTH_PX / view.shape[1])
    return cv2.resize(view, (WIDTH_PX, height_px), interpolation=cv2.INTER_AREA)


if __name__ == "__main__":
    main()
