"""Paints docs/images/objects.jpg: every object on the belt, and what the trackers are taught of it.

`python scripts/objects_picture.py`; below each object its reference picture, at the same scale for
all, without what is not its face.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from experiments.belt.cell import make_cell
from experiments.belt.config import TrialConfig
from sim.belt.carriers import BELT_CENTRE_X_M, Pose
from sim.belt.objects import OBJECTS

TARGET = Path(__file__).resolve().parent.parent / "docs" / "images" / "objects.jpg"
TILE_PX = 240
BACKGROUND = 245
YAW_RAD = 1.1


def photograph(name: str) -> np.ndarray:
    """(TILE_PX, TILE_PX, 3) uint8 view of the object on the belt."""
    cell = make_cell(TrialConfig(object=name), has_camera=True)
    task, physics = cell.task, cell.environment.physics
    task.lay_for_teaching(physics, Pose(BELT_CENTRE_X_M, 0.0, YAW_RAD))
    rgb, _ = task.render(physics, "sensor")
    middle = task.K @ np.linalg.inv(task.view.T_world_camera)[:3] @ [BELT_CENTRE_X_M, 0, 0.04, 1]
    column, row = np.rint(middle[:2] / middle[2]).astype(int)
    half = TILE_PX // 4
    crop = rgb[row - half : row + half, column - half : column + half]
    return cv2.resize(crop, (TILE_PX, TILE_PX), interpolation=cv2.INTER_CUBIC)


def taught(name: str) -> np.ndarray:
    """(TILE_PX // 2, TILE_PX, 3) uint8 reference picture of its face."""
    template = make_cell(TrialConfig(object=name), has_camera=True).template
    tile = np.full((TILE_PX // 2, TILE_PX), BACKGROUND, np.uint8)
    picture = np.where(template.mask, template.picture, BACKGROUND)
    rows, columns = picture.shape
    top, left = (tile.shape[0] - rows) // 2, (tile.shape[1] - columns) // 2
    tile[top : top + rows, left : left + columns] = picture
    return cv2.cvtColor(tile, cv2.COLOR_GRAY2RGB)


def main() -> None:
    """Paints the picture."""
    tiles = [np.vstack([photograph(name), taught(name)]) for name in OBJECTS]
    picture = cv2.cvtColor(np.hstack(tiles), cv2.COLOR_RGB2BGR)
    cv2.imwrite(str(TARGET), picture, [cv2.IMWRITE_JPEG_QUALITY, 90])
    print(f"{TARGET.relative_to(TARGET.parents[2])}: {', '.join(OBJECTS)}")


if __name__ == "__main__":
    main()
