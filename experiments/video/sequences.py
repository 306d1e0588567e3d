"""Video sequences in the layout of OTB: `NAME/img/*.jpg` and `NAME/groundtruth_rect.txt`.

A ground-truth line is `x y w h` of one frame, separated by commas, tabs or blanks; x and y are
1-based, as the benchmark has them. A folder of several targets has `groundtruth_rect.1.txt` and
so on instead, and its sequences are NAME-1 and so on. Optional beside it: `attrs.txt` (challenges),
`init_omit.txt` (first and last image of stretches in which no run may start), and what
`affine_truth` reads. Source of the format and its exceptions: [OTB2015].
"""

import math
import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from experiments.video import tb50
from experiments.video.affine_truth import AffineTruth, read_affine_truth
from experiments.video.images import SequenceError, image_number, image_paths, read_image

GROUND_TRUTH = "groundtruth_rect.txt"

_NO_SEQUENCES = {"errors", "tables", "videos"}
"""Folders that stand beside rendered sequences."""


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
