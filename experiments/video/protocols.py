"""OPE, TRE and SRE: which part of a sequence a tracker runs on, and from which box.

One-pass, temporal and spatial robustness evaluation [OTB2015]. Where the paper is short, the
benchmark's MATLAB code is the reference (`splitSeqTRE`, `shiftInitBB`), rounding included.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from experiments.video.sequences import SequenceError, VideoSequence

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


@dataclass(frozen=True)
class EvaluationProtocol:
    """A way to start trackers on a sequence."""

    description: str
    starts: Callable[[VideoSequence], list[Run]]


def runs_of(protocol: str, sequence: VideoSequence) -> list[Run]:
    """The runs of a protocol; SequenceError for a start from a box that shows no pixel."""
    runs = PROTOCOLS[protocol].starts(sequence)
    width, height = sequence.size_px
    for run in runs:
        x, y, w, h = (float(value) for value in run.box)
        box = f"{sequence.line(run.first)}: the box {x:g},{y:g},{w:g},{h:g} that {protocol} starts"
        if not (math.isfinite(x + y + w + h) and w > 0 and h > 0):
            raise SequenceError(f"{box} from ({run.name}) has no area")
        if x >= width + 1 or y >= height + 1 or x + w <= 1 or y + h <= 1:
            raise SequenceError(
                f"{box} from ({run.name}) is outside the image of {width} x {height} px"
            )
    return runs


def one_pass(sequence: VideoSequence) -> list[Run]:
    """One run from the first box."""
    return [Run("1", 0, sequence.boxes[0])]


def temporal(sequence: VideoSequence) -> list[Run]:
    """Twenty runs from frames spread over the sequence, each to its end.

    Starts are taken from the m frames with a valid box, outside the stretches where none may
    start, with at least 20 frames to go: `[floor(1 : m/19 : m), m]`. So the first run is that of
    OPE, and fewer than 19 such frames give fewer runs, some of them twice. Without any (the
    reference code fails) there is one pass.
    """
    is_usable = np.all(sequence.boxes > 0, axis=1)
    for first, last in sequence.no_start:
        is_usable[max(first - 1, 0) : max(last, 0)] = False
    is_usable[max(len(sequence) - TRE_MIN_FRAMES + 1, 0) :] = False
    usable = np.flatnonzero(is_usable)
    m, steps = len(usable), TRE_SEGMENTS - 1
    if m == 0:
        return one_pass(sequence)
    places = [k * m // steps for k in range(steps) if k * m <= steps * (m - 1)]
    starts = [int(usable[place]) for place in [*places, m - 1]]
    return [Run(str(k), first, sequence.boxes[first]) for k, first in enumerate(starts, start=1)]


def spatial(sequence: VideoSequence) -> list[Run]:
    """Twelve runs from the first frame with a disturbed box.

    The box moves by 10 % in four directions; or grows by 10 % at one of the four corners; or is
    scaled about its centre by 0.8, 0.9, 1.1 and 1.2. Then it is clipped to the image.
    """
    x, y, w, h = (float(value) for value in sequence.boxes[0])
    step_x, step_y = math.ceil(SRE_SHIFT * w), math.ceil(SRE_SHIFT * h)
    left, top = _round(x - SRE_SHIFT * w), _round(y - SRE_SHIFT * h)
    right = _round(x + w - 1 + SRE_SHIFT * w) + 1
    bottom = _round(y + h - 1 + SRE_SHIFT * h) + 1
    boxes: dict[str, tuple[float, ...]] = {
        "left": (x - step_x, y, w, h),
        "right": (x + step_x, y, w, h),
        "up": (x, y - step_y, w, h),
        "down": (x, y + step_y, w, h),
        "top-left": (left, top, x + w - left, y + h - top),
        "top-right": (x, top, right - x, y + h - top),
        "bottom-left": (left, y, x + w - left, bottom - y),
        "bottom-right": (x, y, right - x, bottom - y),
    }
    for scale in SRE_SCALES:
        corner = x + w / 2 - scale * w / 2, y + h / 2 - scale * h / 2
        boxes[f"scale-{scale:g}"] = tuple(map(_round, (*corner, scale * w, scale * h)))
    return [Run(name, 0, _clipped(box, sequence.size_px)) for name, box in boxes.items()]


PROTOCOLS = {
    "ope": EvaluationProtocol("one pass from the first true box", one_pass),
    "tre": EvaluationProtocol("20 runs from frames spread over the sequence", temporal),
    "sre": EvaluationProtocol("12 runs from a shifted or scaled first box", spatial),
}


def _round(value: float) -> float:
    """To the nearest integer, halves away from zero, as MATLAB does."""
    return math.copysign(math.floor(abs(value) + 0.5), value)


def _clipped(box: tuple[float, ...], size_px: tuple[int, int]) -> np.ndarray:
    """A 1-based box that starts in the image and ends in it.

    Moved in at the left and the top, where it keeps its size; cut off at the right and the bottom.
    """
    x, y, w, h = box
    x, y = max(x, 1.0), max(y, 1.0)
    return np.array([x, y, min(w, size_px[0] - x + 1), min(h, size_px[1] - y + 1)])
