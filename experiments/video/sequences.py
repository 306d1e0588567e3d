"""Video sequences in the layout of OTB: `NAME/img/*.jpg` and `NAME/groundtruth_rect.txt`.

A ground-truth line is `x y w h` of one frame, separated by commas, tabs or blanks; x and y are
1-based, as the benchmark has them. A folder of several targets has `groundtruth_rect.1.txt` and
so on instead, and its sequences are NAME-1 and so on. Optional beside it: `attrs.txt` (challenges),
`init_omit.txt` (first and last image of stretches in which no run may start), and the exact truth
of a rendered sequence: `affine.csv` with `frame,a11,a12,a21,a22,x,y,visible` and `corners.csv` with
`frame,x1,y1,...,x4,y4`, frames counted from 1, pixels from 0 with their centres at integers.
Source of the format and its exceptions: [OTB2015].
"""

import math
import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import cv2
import numpy as np

from experiments.video import tb50

GROUND_TRUTH = "groundtruth_rect.txt"
AFFINE_FILE, CORNERS_FILE = "affine.csv", "corners.csv"
AFFINE_HEADER = "frame,a11,a12,a21,a22,x,y,visible"
CORNERS_HEADER = "frame,x1,y1,x2,y2,x3,y3,x4,y4"
IMAGE_SUFFIXES = (".jpg", ".jpeg", ".png", ".bmp")

_ENDS = {b"\xff\xd8": b"\xff\xd9", b"\x89P": b"IEND"}
"""First bytes of JPEG and PNG, and what the last bytes hold."""
_TAIL_BYTES = 64

_NO_SEQUENCES = {"errors", "tables", "videos"}
"""Folders that stand beside rendered sequences."""


class SequenceError(ValueError):
    """A sequence that cannot be used; the message names the file and, where it has, the line."""


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


@dataclass(frozen=True, eq=False)
class VideoSequence:
    """Images, boxes and challenges of one target."""

    name: str
    ground_truth: Path
    image_paths: tuple[Path, ...]
    boxes: np.ndarray
    """(n, 4) x, y, w, h [px], x and y 1-based; as in the file, invalid ones included."""
    attributes: tuple[str, ...] = ()
    no_start: tuple[tuple[int, int], ...] = ()
    """First and last frame, counted from 1, of stretches in which no run of TRE starts."""
    affine: AffineTruth | None = None
    """The true warps, where the sequence has them."""
    spare_image_count: int = 0
    """Images after the last box, which do not count."""

    def __post_init__(self) -> None:
        self.boxes.setflags(write=False)

    def __len__(self) -> int:
        return len(self.boxes)

    @cached_property
    def size_px(self) -> tuple[int, int]:
        """Width and height of the first image."""
        height, width = read_image(self.image_paths[0]).shape[:2]
        return width, height

    def image(self, index: int) -> np.ndarray:
        """(h, w, 3) uint8 BGR image of a frame; SequenceError if unreadable or of another size."""
        path = self.image_paths[index]
        image = read_image(path)
        height, width = image.shape[:2]
        if (width, height) != self.size_px:
            first = "{} x {}".format(*self.size_px)
            raise SequenceError(f"{path}: {width} x {height} px, but the first image has {first}")
        return image

    def line(self, index: int) -> str:
        """Names the ground-truth line of a frame, for messages."""
        return f"{self.ground_truth}, line {index + 1}"


def find_sequences(root: Path) -> dict[str, Path]:
    """Name -> ground-truth file of every sequence folder under `root`, in alphabetical order.

    A folder without ground truth is listed too, so that loading it says what is missing.
    """
    if not root.is_dir():
        raise SequenceError(f"root must be a folder of sequences; got {str(root)!r}")
    found: dict[str, Path] = {}
    for folder in sorted(path for path in root.iterdir() if path.is_dir()):
        if folder.name.startswith((".", "__")) or folder.name in _NO_SEQUENCES:
            continue
        several = sorted(folder.glob("groundtruth_rect.[0-9]*.txt"))
        if (folder / GROUND_TRUTH).exists() or not several:
            found[folder.name] = folder / GROUND_TRUTH
        else:
            found |= {f"{folder.name}-{path.stem.split('.')[1]}": path for path in several}
    if not found:
        raise SequenceError(f"root must be a folder of sequences; {str(root)!r} holds none")
    return found


def load_sequence(name: str, ground_truth: Path) -> VideoSequence:
    """Reads all but the images; SequenceError names the file and the line at fault.

    Images after the last box do not count; images that are missing are an error.
    """
    boxes = read_boxes(ground_truth)
    folder = ground_truth.parent
    images = image_paths(folder / "img")
    if len(images) > len(boxes):
        first, last = tb50.FIRST_IMAGE.get(name, 0), tb50.LAST_IMAGE.get(name, math.inf)
        images = [path for path in images if first <= image_number(path) <= last]
    if len(images) < len(boxes):
        raise SequenceError(
            f"{ground_truth}, line {len(images) + 1}: "
            f"{len(boxes)} boxes, but {folder / 'img'} holds {len(images)} images"
        )
    return VideoSequence(
        name=name,
        ground_truth=ground_truth,
        image_paths=tuple(images[: len(boxes)]),
        boxes=boxes,
        attributes=read_attributes(name, folder),
        no_start=_read_no_start(name, folder, image_number(images[0])),
        affine=read_affine_truth(folder, len(boxes)),
        spare_image_count=len(images) - len(boxes),
    )


def read_boxes(path: Path) -> np.ndarray:
    """(n, 4) boxes of a ground-truth file, NaN allowed."""
    lines = _read_lines(path)
    if not lines:
        raise SequenceError(f"{path}, line 1: no boxes")
    boxes = np.empty((len(lines), 4))
    for number, line in enumerate(lines, start=1):
        try:
            x, y, w, h = (float(word) for word in _words(line))
        except ValueError:
            raise SequenceError(f"{path}, line {number}: not a box x y w h: {line!r}") from None
        boxes[number - 1] = x, y, w, h
        if np.isinf(boxes[number - 1]).any():
            raise SequenceError(f"{path}, line {number}: not a box x y w h: {line!r}")
    return boxes


def read_attributes(name: str, folder: Path) -> tuple[str, ...]:
    """Challenges from `attrs.txt` of the folder, else from the list of TB-50."""
    path = folder / "attrs.txt"
    if not path.exists():
        return tb50.TB50_ATTRIBUTES.get(name, ())
    found: list[str] = []
    for number, line in enumerate(_read_lines(path), start=1):
        for word in _words(line):
            if word not in tb50.ATTRIBUTES:
                known = ", ".join(tb50.ATTRIBUTES)
                raise SequenceError(
                    f"{path}, line {number}: attribute must be one of {known}; got {word!r}"
                )
            found.append(word)
    return tuple(found)


def _read_no_start(name: str, folder: Path, first_image: int) -> tuple[tuple[int, int], ...]:
    """From `init_omit.txt` of the folder, else from the benchmark's list; as frames from 1."""
    path = folder / "init_omit.txt"
    lines = tb50.NO_START.get(name.lower(), "").replace("-", ",").split()
    if path.exists():
        lines = _read_lines(path)
    stretches: list[tuple[int, int]] = []
    for number, line in enumerate(lines, start=1):
        try:
            first, last = (int(word) - first_image + 1 for word in _words(line))
        except ValueError:
            raise SequenceError(
                f"{path}, line {number}: two image numbers expected, got {line!r}"
            ) from None
        stretches.append((first, last))
    return tuple(stretches)


def _read_lines(path: Path) -> list[str]:
    try:
        return path.read_text(encoding="utf-8", errors="replace").rstrip().splitlines()
    except OSError as error:
        raise SequenceError(f"{path}: {error.strerror}") from None


def _words(line: str) -> list[str]:
    return re.findall(r"[^,\s]+", line)


def image_paths(folder: Path) -> list[Path]:
    """The images in `folder` by the number in their names."""
    if not folder.is_dir():
        raise SequenceError(f"{folder}: no such folder; the images of a sequence are in img/")
    found = [path for path in folder.iterdir() if path.suffix.lower() in IMAGE_SUFFIXES]
    return sorted(found, key=image_number)


def image_number(path: Path) -> int:
    """The number in an image's name, for example 300 of `0300.jpg`."""
    digits = re.findall(r"\d+", path.stem)
    if not digits:
        raise SequenceError(f"{path}: no frame number in the name")
    return int(digits[-1])


def read_image(path: Path) -> np.ndarray:
    """(h, w, 3) uint8 BGR; SequenceError for what is no image or not a whole one.

    OpenCV fills what is missing of a file that was cut short with grey, so its end is looked at.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise SequenceError(f"{path}: {error.strerror}") from None
    end = _ENDS.get(data[:2], b"")
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR) if data else None
    if image is None:
        raise SequenceError(f"{path}: not a readable image")
    if end not in data[-_TAIL_BYTES:]:
        raise SequenceError(f"{path}: the image is cut short")
    return image


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
    lines = _read_lines(path)
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
