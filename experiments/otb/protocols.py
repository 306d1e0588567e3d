"""OPE, TRE and SRE: which part of a sequence a tracker runs on, and from which box.

One-pass, temporal and spatial robustness evaluation [OTB2015], by the benchmark's reference code.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from experiments.otb.sequences import VideoSequence

TRE_SEGMENTS = 20
TRE_MIN_FRAMES = 20
SRE_SHIFT = 0.1
SRE_SCALES = (0.8, 0.9, 1.1, 1.2)


@dataclass(frozen=True, eq=False)
class Run:
    """One start of a tracker; it runs to the end of the sequence."""

    name: str
    """Unique within the protocol: its number, or the disturbance of the first box."""
    first: int
    """Index of the first frame."""
    box: np.ndarray
    """(4,) x, y, w, h given to the tracker on that frame; x and y 1-based."""


def one_pass(sequence: VideoSequence) -> list[Run]:
    """One run from the first box."""
    return [Run("1", 0, sequence.boxes[0])]


def temporal(sequence: VideoSequence) -> list[Run]:
    """Twenty runs from frames spread over the sequence, each to its end.

    Starts are taken from the frames with a valid box; the last has at least 20 frames to go.
    """
    usable = np.flatnonzero((sequence.boxes > 0).all(axis=1))
    is_long = len(sequence) - usable >= TRE_MIN_FRAMES
    last = int(np.count_nonzero(is_long))
    if last < 1:
        return one_pass(sequence)
    step = last / (TRE_SEGMENTS - 1)
    places = [math.floor(1 + k * step) for k in range(TRE_SEGMENTS - 1)]
    starts = dict.fromkeys(int(usable[place - 1]) for place in [*places, last])
    return [Run(str(k), first, sequence.boxes[first]) for k, first in enumerate(starts, start=1)]


def spatial(sequence: VideoSequence) -> list[Run]:
    """Twelve runs from the first frame with a disturbed box.

    The centre moves by 10 % in four directions; one of the four corners moves outward by 10 %; the
    box is scaled about its centre by 0.8, 0.9, 1.1 and 1.2. All are clipped to the image.
    """
    x, y, w, h = sequence.boxes[0]
    dx, dy = math.ceil(SRE_SHIFT * w), math.ceil(SRE_SHIFT * h)
    boxes = {
        "left": (x - dx, y, w, h),
        "right": (x + dx, y, w, h),
        "up": (x, y - dy, w, h),
        "down": (x, y + dy, w, h),
        "top-left": (x - dx, y - dy, w + dx, h + dy),
        "top-right": (x, y - dy, w + dx, h + dy),
        "bottom-left": (x - dx, y, w + dx, h + dy),
        "bottom-right": (x, y, w + dx, h + dy),
    }
    for scale in SRE_SCALES:
        size = np.array([round(scale * w), round(scale * h)])
        corner = np.round(np.array([x, y]) + (np.array([w, h]) - size) / 2)
        boxes[f"scale-{scale:g}"] = (*corner, *size)
    height, width = sequence.image(0).shape[:2]
    return [
        Run(name, 0, _clipped(np.array(box, float), width, height)) for name, box in boxes.items()
    ]


PROTOCOLS: dict[str, Callable[[VideoSequence], list[Run]]] = {
    "ope": one_pass,
    "tre": temporal,
    "sre": spatial,
}
"""One-pass, temporal and spatial robustness evaluation."""


def _clipped(box: np.ndarray, width_px: int, height_px: int) -> np.ndarray:
    """The part of a 1-based box that lies in the image."""
    low = np.maximum(box[:2], 1.0)
    high = np.minimum(box[:2] + box[2:], [width_px + 1.0, height_px + 1.0])
    return np.concatenate([low, np.maximum(high - low, 1.0)])
