"""Video sequences in the layout of OTB: `NAME/img/*.jpg` and `NAME/groundtruth_rect.txt`.

A ground-truth line is `x y w h` of one frame, separated by commas, tabs or blanks; x and y are
1-based, as the benchmark has them. The format and its exceptions: [OTB2015].
"""

from __future__ import annotations

import re
from collections.abc import Sequence as Items
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

IMAGE_SUFFIXES = (".jpg", ".jpeg", ".png", ".bmp")
GROUND_TRUTH = "groundtruth_rect.txt"

ATTRIBUTES = {
    "IV": "illumination variation",
    "SV": "scale variation",
    "OCC": "occlusion",
    "DEF": "deformation",
    "MB": "motion blur",
    "FM": "fast motion",
    "IPR": "in-plane rotation",
    "OPR": "out-of-plane rotation",
    "OV": "out of view",
    "BC": "background clutter",
    "LR": "low resolution",
}
"""The eleven challenges by which the benchmark groups its sequences."""

TB50_ATTRIBUTES = {
    name: tuple(tags.split(","))
    for name, tags in (
        line.split()
        for line in """
        Basketball IV,OCC,DEF,OPR,BC
        Biker SV,OCC,MB,FM,OPR,OV,LR
        Bird1 DEF,FM,OV
        BlurBody SV,DEF,MB,FM,IPR
        BlurCar2 SV,MB,FM
        BlurFace MB,FM,IPR
        BlurOwl SV,MB,FM,IPR
        Bolt OCC,DEF,IPR,OPR
        Box IV,SV,OCC,MB,IPR,OPR,OV,BC,LR
        Car1 IV,SV,MB,FM,BC,LR
        Car4 IV,SV
        CarDark IV,BC
        CarScale SV,OCC,FM,IPR,OPR
        ClifBar SV,OCC,MB,FM,IPR,OV,BC
        Couple SV,DEF,FM,OPR,BC
        Crowds IV,DEF,BC
        David IV,SV,OCC,DEF,MB,IPR,OPR
        Deer MB,FM,IPR,BC,LR
        Diving SV,DEF,IPR
        DragonBaby SV,OCC,MB,FM,IPR,OPR,OV
        Dudek SV,OCC,DEF,FM,IPR,OPR,OV,BC
        Football OCC,IPR,OPR,BC
        Freeman4 SV,OCC,IPR,OPR
        Girl SV,OCC,IPR,OPR
        Human3 SV,OCC,DEF,OPR,BC
        Human4-2 IV,SV,OCC,DEF
        Human6 SV,OCC,DEF,FM,OPR,OV
        Human9 IV,SV,DEF,MB,FM
        Ironman IV,SV,OCC,MB,FM,IPR,OPR,OV,BC,LR
        Jump SV,OCC,DEF,MB,FM,IPR,OPR
        Jumping MB,FM
        Liquor IV,SV,OCC,MB,FM,OPR,OV,BC
        Matrix IV,SV,OCC,FM,IPR,OPR,BC
        MotorRolling IV,SV,MB,FM,IPR,BC,LR
        Panda SV,OCC,DEF,IPR,OPR,OV,LR
        RedTeam SV,OCC,IPR,OPR,LR
        Shaking IV,SV,IPR,OPR,BC
        Singer2 IV,DEF,IPR,OPR,BC
        Skating1 IV,SV,OCC,DEF,OPR,BC
        Skating2-1 SV,OCC,DEF,FM,OPR
        Skating2-2 SV,OCC,DEF,FM,OPR
        Skiing IV,SV,DEF,IPR,OPR
        Soccer IV,SV,OCC,MB,FM,IPR,OPR,BC
        Surfer SV,FM,IPR,OPR,LR
        Sylvester IV,IPR,OPR
        Tiger2 IV,OCC,DEF,MB,FM,IPR,OPR,OV
        Trellis IV,SV,IPR,OPR,BC
        Walking SV,OCC,DEF
        Walking2 SV,OCC,LR
        Woman IV,SV,OCC,DEF,MB,FM,OPR
        """.strip().splitlines()
    )
}
"""The fifty sequences of TB-50 and their challenges, by the benchmark's own list."""

FIRST_FRAME = {"David": 300, "BlurCar1": 247, "BlurCar3": 3, "BlurCar4": 18}
"""Number of the image that the first box belongs to, where it is not the first image."""


class SequenceError(ValueError):
    """A sequence that cannot be used; the message names the file and the line."""


@dataclass(frozen=True, eq=False)
class VideoSequence:
    """Images, boxes and challenges of one target."""

    name: str
    image_paths: tuple[Path, ...]
    boxes: np.ndarray
    """(n, 4) x, y, w, h [px], x and y 1-based; as in the file, invalid ones included."""
    attributes: tuple[str, ...]

    def __post_init__(self) -> None:
        self.boxes.setflags(write=False)

    def __len__(self) -> int:
        return len(self.image_paths)

    def image(self, index: int) -> np.ndarray:
        """(h, w, 3) uint8 BGR image of a frame; SequenceError where it cannot be read."""
        path = self.image_paths[index]
        image = cv2.imread(str(path), cv2.IMREAD_COLOR)
        if image is None:
            raise SequenceError(f"{path}: not a readable image")
        return image


def find_sequences(root: Path) -> list[str]:
    """Names of the folders under `root` that look like sequences, in alphabetical order."""
    if not root.is_dir():
        raise SequenceError(f"{root}: no such folder")
    return sorted(path.parent.name for path in root.glob(f"*/{GROUND_TRUTH}"))


def load_sequence(folder: Path) -> VideoSequence:
    """Reads boxes and finds images; more images than boxes are cut to the boxes' frames."""
    images = _image_paths(folder)
    boxes = _read_boxes(folder / GROUND_TRUTH)
    name = folder.name
    first = FIRST_FRAME.get(name, 0)
    if len(images) > len(boxes) and first:
        images = [path for path in images if _number(path) >= first]
    if len(images) < len(boxes):
        raise SequenceError(
            f"{folder / GROUND_TRUTH}: {len(boxes)} boxes for {len(images)} images in img/"
        )
    if len(boxes) == 0:
        raise SequenceError(f"{folder / GROUND_TRUTH}: no boxes")
    return VideoSequence(name, tuple(images[: len(boxes)]), boxes, _read_attributes(folder))


def select(
    names: Items[str], wanted: Items[str], attributes: dict[str, tuple[str, ...]]
) -> list[str]:
    """The names that `wanted` asks for by name or by attribute; all where it is empty.

    Raises SequenceError for a word that is neither.
    """
    for word in wanted:
        if word not in names and word not in ATTRIBUTES:
            raise SequenceError(
                f"no sequence or attribute {word!r}; sequences: {', '.join(names)}; "
                f"attributes: {', '.join(ATTRIBUTES)}"
            )
    chosen = set(wanted)
    return [n for n in names if not chosen or n in chosen or chosen & set(attributes.get(n, ()))]


def _image_paths(folder: Path) -> list[Path]:
    if not (folder / "img").is_dir():
        raise SequenceError(f"{folder}: has no folder img/")
    found = (folder / "img").iterdir()
    return sorted((p for p in found if p.suffix.lower() in IMAGE_SUFFIXES), key=_number)


def _number(path: Path) -> int:
    digits = re.findall(r"\d+", path.stem)
    if not digits:
        raise SequenceError(f"{path}: no frame number in the name")
    return int(digits[-1])


def _read_boxes(path: Path) -> np.ndarray:
    try:
        lines = path.read_text(encoding="utf-8").rstrip().splitlines()
    except OSError as error:
        raise SequenceError(f"{path}: {error.strerror}") from None
    boxes = np.empty((len(lines), 4))
    for number, line in enumerate(lines, start=1):
        words = re.split(r"[,\s]+", line.strip())
        try:
            boxes[number - 1] = [float(word) for word in words]
        except ValueError:
            raise SequenceError(
                f"{path}, line {number}: four numbers x y w h expected, got {line!r}"
            ) from None
    return boxes


def _read_attributes(folder: Path) -> tuple[str, ...]:
    """From `attrs.txt` beside the images, else from the list of TB-50."""
    path = folder / "attrs.txt"
    if not path.exists():
        return TB50_ATTRIBUTES.get(folder.name, ())
    words = re.split(r"[,\s]+", path.read_text(encoding="utf-8").strip())
    return tuple(word for word in words if word)
