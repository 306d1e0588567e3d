"""Precision and success of predicted boxes, with the semantics of the reference benchmark.

[OTB2015] and the benchmark's MATLAB code (`calcSeqErrRobust`): frame 1 counts, with the ground
truth as prediction; a prediction without area repeats the one before; a frame without a valid true
box counts as an overlap miss and, by the reference's error of -1, as a precision hit.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

OVERLAP_THRESHOLDS = np.arange(21) / 20
"""Success is an overlap above the threshold."""
ERROR_THRESHOLDS_PX = np.arange(51.0)
"""Precision is a centre error of at most the threshold."""
DP_ERROR_PX = 20
HIT_COLUMNS = (
    *(f"overlap_above_{threshold:.2f}" for threshold in OVERLAP_THRESHOLDS),
    *(f"error_within_{threshold:.0f}_px" for threshold in ERROR_THRESHOLDS_PX),
)
"""Names of the numbers of frames behind the curves."""


@dataclass(frozen=True, eq=False)
class Curves:
    """Shares of frames over the thresholds, for one sequence or a mean of several."""

    success: np.ndarray
    """(21,) at OVERLAP_THRESHOLDS."""
    precision: np.ndarray
    """(51,) at ERROR_THRESHOLDS_PX."""

    def hits(self, frame_count: int) -> list[int]:
        """The (72,) numbers of frames behind the shares: success, then precision."""
        shares = np.concatenate([self.success, self.precision])
        return np.rint(shares * frame_count).astype(int).tolist()

    @classmethod
    def of_hits(cls, hits: Sequence[int], frame_count: int) -> Self:
        """The curves of so many hits among so many frames."""
        shares = np.array(hits) / frame_count
        return cls(shares[: len(OVERLAP_THRESHOLDS)], shares[len(OVERLAP_THRESHOLDS) :])

    @property
    def overlap_score(self) -> float:
        """OS: mean of the success curve (its area). A perfect tracker has 20/21."""
        return float(self.success.mean())

    @property
    def distance_precision(self) -> float:
        """DP: precision at 20 px."""
        return float(self.precision[DP_ERROR_PX])


def sequence_curves(predictions: Sequence[np.ndarray], truths: Sequence[np.ndarray]) -> Curves:
    """All hits of all runs over all frames of all runs: long runs weigh more.

    Args:
        predictions: boxes (n_i, 4) of each run on the sequence.
        truths: true boxes (n_i, 4) of the same frames.
    """
    success = np.zeros(len(OVERLAP_THRESHOLDS))
    precision = np.zeros(len(ERROR_THRESHOLDS_PX))
    for predicted, true in zip(predictions, truths, strict=True):
        overlap, error_px = overlap_and_error(predicted, true)
        success += (overlap[:, None] > OVERLAP_THRESHOLDS).sum(axis=0)
        precision += (error_px[:, None] <= ERROR_THRESHOLDS_PX).sum(axis=0)
    frames = sum(len(true) for true in truths)
    return Curves(success / frames, precision / frames)


def mean_curves(curves: Sequence[Curves]) -> Curves:
    """Plain mean over sequences, whatever their length."""
    return Curves(
        np.mean([c.success for c in curves], axis=0),
        np.mean([c.precision for c in curves], axis=0),
    )


def overlap_and_error(predicted: np.ndarray, true: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Overlap (n,) and centre error [px] (n,) of one run; both -1 where the truth is invalid."""
    if predicted.shape != true.shape:
        raise ValueError(f"predicted {predicted.shape} and true {true.shape} boxes must agree")
    boxes = _repaired(predicted, true)
    boxes[0] = true[0]
    is_valid = (true > 0).all(axis=1)
    with np.errstate(invalid="ignore"):
        error_px = np.linalg.norm(centres(boxes) - centres(true), axis=1)
        overlap = overlaps(boxes, true)
    return np.where(is_valid, overlap, -1.0), np.where(is_valid, error_px, -1.0)


def centres(boxes: np.ndarray) -> np.ndarray:
    """(n, 2) centres of boxes (n, 4) on the benchmark's pixel grid."""
    return boxes[:, :2] + (boxes[:, 2:] - 1.0) / 2.0


def overlaps(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(n,) intersection over union of boxes (n, 4), pair by pair; rounding stays below 1."""
    low = np.maximum(a[:, :2], b[:, :2])
    high = np.minimum(a[:, :2] + a[:, 2:], b[:, :2] + b[:, 2:])
    common = np.prod(np.maximum(high - low, 0.0), axis=1)
    union = np.prod(a[:, 2:], axis=1) + np.prod(b[:, 2:], axis=1) - common
    return np.minimum(common / np.maximum(union, 1e-12), 1.0)


def _repaired(boxes: np.ndarray, true: np.ndarray) -> np.ndarray:
    """A copy in which a box that is NaN or has no area repeats the one before.

    Not so on a frame whose true box is NaN, and not the first box, as in the reference code.
    """
    boxes = np.array(boxes, float)
    is_bad = np.all(np.isnan(boxes), axis=1) | np.any(boxes[:, 2:] <= 0, axis=1)
    is_bad &= ~np.isnan(true).any(axis=1)
    for index in np.flatnonzero(is_bad[1:]) + 1:
        boxes[index] = boxes[index - 1]
    return boxes
