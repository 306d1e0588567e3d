"""The true warp, corners and visibility of a rendered sequence, frame by frame.

`affine.csv`: `frame,a11,a12,a21,a22,x,y,visible`; `corners.csv`: `frame,x1,y1,...,x4,y4`. Frames
are counted from 1, pixels from 0 with their centres at integers.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.video.images import SequenceError

AFFINE_FILE, CORNERS_FILE = "affine.csv", "corners.csv"
AFFINE_HEADER = "frame,a11,a12,a21,a22,x,y,visible"
CORNERS_HEADER = "frame,x1,y1,x2,y2,x3,y3,x4,y4"


@dataclass(frozen=True, eq=False)
class AffineTruth:
    """Where the target truly is on each of the n frames."""

    warps: np.ndarray
    """(n, 3, 3) template -> image [px]; the template has its origin at the centre of the first
    frame's target and the unit sqrt(w h) of the first box."""
    corners: np.ndarray
    """(n, 4, 2) image [px]: top left, top right, bottom right, bottom left of the target."""
    visible: np.ndarray
    """(n,) share of the target that can be seen, from 0 to 1."""

    def __post_init__(self) -> None:
        for array in (self.warps, self.corners, self.visible):
            array.setflags(write=False)


def read_affine_truth(folder: Path, frame_count: int) -> AffineTruth | None:
    """The truth of a sequence folder; None where it has none."""
    if not (folder / AFFINE_FILE).exists():
        return None
    affine = _read_table(folder / AFFINE_FILE, AFFINE_HEADER, frame_count)
    corners = _read_table(folder / CORNERS_FILE, CORNERS_HEADER, frame_count)
    warps = np.tile(np.eye(3), (frame_count, 1, 1))
    warps[:, :2, :2] = affine[:, :4].reshape(-1, 2, 2)
    warps[:, :2, 2] = affine[:, 4:6]
    flat = np.flatnonzero(~(np.linalg.det(warps) > 0))
    if len(flat):
        line = f"{folder / AFFINE_FILE}, line {flat[0] + 2}"
        raise SequenceError(f"{line}: the warp's determinant must be positive")
    return AffineTruth(warps, corners.reshape(-1, 4, 2), affine[:, 6])


def _read_table(path: Path, header: str, frame_count: int) -> np.ndarray:
    """(frame_count, columns - 1) numbers of a CSV file with a line for each frame in order."""
    try:
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError as error:
        raise SequenceError(f"{path}: {error.strerror}") from None
    if lines[:1] != [header]:
        raise SequenceError(f"{path}, line 1: the header must be {header}")
    table = np.empty((frame_count, header.count(",")))
    for frame in range(1, frame_count + 1):
        line = lines[frame] if frame < len(lines) else "nothing"
        try:
            number, *values = (float(word) for word in line.split(","))
            if (number, len(values)) != (frame, table.shape[1]) or not np.isfinite(values).all():
                raise ValueError
            table[frame - 1] = values
        except ValueError:
            raise SequenceError(
                f"{path}, line {frame + 1}: {header} of frame {frame} expected, got {line}"
            ) from None
    return table
