"""Paints docs/images/grasp.jpg: one attempt in four moments, camera above, cell below.

python scripts/readme_picture.py
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from experiments.cell import make_cell
from experiments.config import TrialConfig
from experiments.loop import Loop
from experiments.video import camera_view, cell_view
from sim.grasp import Phase

CONFIG = TrialConfig(tracker="igpf", speed_mps=0.5, seed=1)
MOMENTS = ((Phase.TRACK, 0.05), (Phase.DESCEND, 0.02), (Phase.CLOSE, 0.12), (Phase.HOLD, 0.3))
"""Phases, and how long after their beginning [s]."""
PATH = Path(__file__).parents[1] / "docs" / "images" / "grasp.jpg"
WIDTH_PX = 400


def main() -> None:
    """Runs the attempt and writes the picture."""
    loop, columns = Loop(CONFIG, make_cell(CONFIG, has_camera=True)), []
    while loop.is_running and len(columns) < len(MOMENTS):
        loop.step()
        phase, after_s = MOMENTS[len(columns)]
        if loop.time_s >= loop.grasp.entered_s.get(phase, np.inf) + after_s:
            views = [camera_view(loop, "camera")[:340], cell_view(loop)[100:]]
            columns.append(np.vstack([_small(view) for view in views]))
    cv2.imwrite(str(PATH), np.hstack(columns)[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 88])
    print(PATH)


def _small(view: np.ndarray) -> np.ndarray:
    height_px = round(view.shape[0] * WIDTH_PX / view.shape[1])
    return cv2.resize(view, (WIDTH_PX, height_px), interpolation=cv2.INTER_AREA)


if __name__ == "__main__":
    main()
