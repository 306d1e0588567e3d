"""Paints docs/images/sequences.jpg: moments of rendered sequences with box and corners.

python scripts/sequences_picture.py out/sequences
"""

from __future__ import annotations

import sys
from pathlib import Path

import cv2
import numpy as np

from experiments.video.sequences import GROUND_TRUTH, load_sequence

PATH = Path(__file__).parents[1] / "docs" / "images" / "sequences.jpg"
MOMENTS = {
    "Flicker": (0, 15, 89),
    "Spotlight": (0, 15, 44),
    "Approach": (0, 20, 50),
    "Posts": (0, 22, 34),
    "Flag": (0, 15, 30),
    "Rubber": (0, 30, 89),
    "Streak": (0, 30, 60),
    "Hummingbird": (0, 1, 2),
    "Wheel": (0, 25, 60),
    "Carton": (0, 45, 60),
    "Dive": (0, 20, 87),
    "Gallery": (0, 30, 60),
    "Speck": (0, 30, 60),
    "Storm": (0, 25, 50),
}
"""Sequences and frames, counted from 0."""
COLUMNS = 2
WIDTH_PX = 216
BOX_BGR, CORNERS_BGR = (0, 255, 255), (80, 255, 80)


def main(root: Path) -> None:
    """Reads the sequences under `root` and writes the picture."""
    strips = [_strip(root / name, frames) for name, frames in MOMENTS.items()]
    rows = [np.hstack(strips[k : k + COLUMNS]) for k in range(0, len(strips), COLUMNS)]
    cv2.imwrite(str(PATH), np.vstack(rows), [cv2.IMWRITE_JPEG_QUALITY, 80])
    print(PATH)


def _strip(folder: Path, frames: tuple[int, ...]) -> np.ndarray:
    """The frames side by side, each with a rim."""
    sequence = load_sequence(folder.name, folder / GROUND_TRUTH)
    corners = np.loadtxt(folder / "corners.csv", delimiter=",", skiprows=1)[:, 1:]
    views = [
        _marked(sequence.image(k), sequence.boxes[k], corners[k].reshape(4, 2)) for k in frames
    ]
    label = f"{sequence.name}  {' '.join(sequence.attributes)}"
    for colour, width in (((0, 0, 0), 3), ((255, 255, 255), 1)):
        cv2.putText(views[0], label, (6, 14), 0, 0.4, colour, width, cv2.LINE_AA)
    return np.hstack([_rimmed(view) for view in views])


def _rimmed(view: np.ndarray) -> np.ndarray:
    return cv2.copyMakeBorder(view, 2, 2, 1, 1, cv2.BORDER_CONSTANT, value=(255,) * 3)


def _marked(image: np.ndarray, box: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """The image at WIDTH_PX with the box (1-based) and the quadrilateral of the corners."""
    scale = WIDTH_PX / image.shape[1]
    height_px = round(image.shape[0] * scale)
    view = cv2.resize(image, (WIDTH_PX, height_px), interpolation=cv2.INTER_AREA)
    low, size = box[:2] - 1.5, box[2:]
    outline = low + size * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    for points, colour in ((outline, BOX_BGR), (corners, CORNERS_BGR)):
        fixed = np.round(((points + 0.5) * scale - 0.5) * 16).astype(np.int32)
        cv2.polylines(view, [fixed], True, colour, 1, cv2.LINE_AA, shift=4)
    return view


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/sequences"))
