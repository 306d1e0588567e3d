"""How far an estimated warp is from the true one: what boxes cannot tell.

A run's template is the box that it was given on its first frame, which may be a later frame of the
sequence (TRE) or a disturbed box (SRE). So its errors are those of the motion since then: the true
one leads from the true warp of the run's first frame to that of the present frame.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from experiments.video.job import AffineRow
from experiments.video.sequences import AffineTruth
from tracker.affine import aff2
from tracker.affine.resampling import Particles
from tracker.base import WarpEstimate
from tracker.box_tracker import BoxEstimate

NEES_MEDIAN = 5.348
"""Median of a chi-squared distribution with the 6 degrees of freedom of a warp; its mean is 6."""


class AffineReferee:
    """Compares the estimates of one run with the truth."""

    def __init__(self, truth: AffineTruth, run: str, first: int, box: np.ndarray) -> None:
        """`box` (4,) x, y, w, h starts the run on the frame of index `first`; x, y from 0."""
        self._truth = truth
        self._run = run
        unit_px = math.sqrt(box[2] * box[3])
        self._start = _box_warp(box, unit_px, unit_px)
        self._start_box = box
        self._in_template = aff2.inverse(truth.warps[first]) @ self._start
        self._corners = np.vstack([truth.corners[first].T, np.ones(4)])
        self._resampling: tuple[Particles, Particles] | None = None

    def note_resampling(self, before: Particles, after: Particles) -> None:
        """Takes what a resampling made of the particles; it counts for the next row."""
        self._resampling = before, after

    def row(self, index: int, estimate: BoxEstimate) -> AffineRow:
        """The errors on the frame of that index."""
        true = self._truth.warps[index] @ self._in_template
        warp = estimate.affine
        resampling, self._resampling = self._resampling, None
        parents = None if resampling is None else resampling[1].parents
        moved = self._motion(estimate) @ self._corners
        distances = np.linalg.norm(moved[:2].T - self._truth.corners[index], axis=1)
        shape = None if warp is None else aff2.polar(aff2.inverse(true) @ warp.warp)[:4]
        scale, aspect, rotation, shear = (None,) * 4 if shape is None else map(float, shape)
        return AffineRow(
            run=self._run,
            frame=index + 1,
            corner_error_px=float(distances.mean()),
            scale_error=scale,
            aspect_error=aspect,
            rotation_error_rad=rotation,
            shear_error=shear,
            nees=None if warp is None else nees(warp, true),
            ess=None if warp is None else warp.ess,
            ancestor_count=None if parents is None else len(np.unique(parents)),
            resampling_distance=None
            if warp is None or resampling is None
            else resampling_distance(warp.warp, *resampling),
            visible=float(self._truth.visible[index]),
        )

    def _motion(self, estimate: BoxEstimate) -> np.ndarray:
        """(3, 3) pixels of the run's first image -> pixels of this one.

        A box only shifts them and stretches them along the axes.
        """
        if estimate.affine is not None:
            return estimate.affine.warp @ aff2.inverse(self._start)
        here = _box_warp(estimate.box, *estimate.box[2:])
        return here @ aff2.inverse(_box_warp(self._start_box, *self._start_box[2:]))


def nees(estimate: WarpEstimate, true: np.ndarray) -> float | None:
    """Normalised estimation error squared of a warp, 6 degrees of freedom; None if undefined."""
    error = aff2.difference(estimate.warp, true)
    try:
        value = float(error @ np.linalg.solve(estimate.covariance, error))
    except np.linalg.LinAlgError:
        return None
    return value if math.isfinite(value) and value >= 0.0 else None


def resampling_distance(centre: np.ndarray, before: Particles, after: Particles) -> float | None:
    """How much resampling changed the distribution; None where no warp is near `centre` (3, 3).

    Root of the energy distance [Szekely2013] between the weighted particles before and the equally
    weighted ones after, each tangent direction in deviations of those before.
    """
    old, new = aff2.difference(centre, before.warps), aff2.difference(centre, after.warps)
    weights = np.where(np.isfinite(old).all(axis=1), before.weights, 0.0)
    old, new = np.nan_to_num(old), new[np.isfinite(new).all(axis=1)]
    if not (weights.sum() > 0 and len(new)):
        return None
    weights = weights / weights.sum()
    deviation = np.sqrt(weights @ (old - weights @ old) ** 2)
    scale = np.where(deviation > 0, deviation, 1.0)
    old, new = old / scale, new / scale
    even = np.full(len(new), 1.0 / len(new))
    squared = (
        2.0 * weights @ _distances(old, new) @ even
        - weights @ _distances(old, old) @ weights
        - even @ _distances(new, new) @ even
    )
    return math.sqrt(max(squared, 0.0))


def _box_warp(box: np.ndarray, unit_x: float, unit_y: float) -> np.ndarray:
    """(3, 3) unrotated warp to the centre of a box (x, y from 0), with these units [px]."""
    x, y, w, h = box
    return np.array([[unit_x, 0, x + (w - 1) / 2], [0, unit_y, y + (h - 1) / 2], [0, 0, 1.0]])


def _distances(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(n, m) Euclidean distances between rows of a (n, d) and b (m, d)."""
    squared = (a**2).sum(axis=1)[:, None] + (b**2).sum(axis=1) - 2.0 * a @ b.T
    return np.sqrt(np.maximum(squared, 0.0))


def calibrated(nees: Mapping[str, Sequence[float]]) -> np.ndarray:
    """All values of NEES by sequence, over the factor that makes the other half's median right.

    So it shows whether a tracker's covariance is honest up to one factor that all sequences share.
    A factor that is fitted on what it is judged by always fits; what is left over tells how much
    the honesty differs between sequences. The halves take turns in the order of the names. Empty if
    one of them has no values.
    """
    halves = [
        np.array([value for name in sorted(nees)[start::2] for value in nees[name]])
        for start in (0, 1)
    ]
    if not all(len(half) and np.median(half) > 0 for half in halves):
        return np.empty(0)
    factors = [np.median(half) / NEES_MEDIAN for half in halves]
    return np.concatenate([halves[0] / factors[1], halves[1] / factors[0]])
