"""Reading the images of a sequence, and telling a damaged one."""

import re
from pathlib import Path

import cv2
import numpy as np

IMAGE_SUFFIXES = (".jpg", ".jpeg", ".png", ".bmp")

_ENDS = {b"\xff\xd8": b"\xff\xd9", b"\x89P": b"IEND"}
"""First bytes of JPEG and PNG, and what the last bytes hold."""
_TAIL_BYTES = 64


class SequenceError(ValueError):
    """A sequence that cannot be used; the message names the file and, where it has, the line."""


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
