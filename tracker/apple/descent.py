"""Levenberg-Marquardt steps of many hypotheses at once; the views' own parameters eliminated."""

import numpy as np

from tracker.apple.hypotheses import (
    AXIS,
    SHARED,
    Hypotheses,
    NormalEquations,
    chosen_of,
    solved,
    without_views,
)
from tracker.apple.outline_model import OutlineModel

_LONGEST_TILT = 0.5
"""Longest turn of the axis in one step [rad]."""
_SMALL_GAIN = 1e-3
"""Steps that lower half the sum of squares by less are the last ones."""
_STUCK = 1e4
"""A hypothesis that needs more damping is at rest."""


def descend(
    model: OutlineModel, hypotheses: Hypotheses, scale_px: float, steps: int
) -> tuple[Hypotheses, NormalEquations]:
    """Levenberg-Marquardt steps of all hypotheses; one that a step makes worse stays.

    A step so long that its cost is no number is such a one.
    """
    system = model.evaluate(hypotheses, scale_px)
    damping, is_done = np.full(len(system.cost), 1e-3), np.zeros(len(system.cost), bool)
    for _ in range(steps):
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            moved = hypotheses.moved(*_step(system, damping))
            after = model.evaluate(moved, scale_px)
        better = after.cost < system.cost
        hypotheses = moved.where(better, hypotheses)
        gain = np.where(better, system.cost - after.cost, 0.0)
        system = chosen_of(better, after, system)
        damping = np.where(better, damping * 0.3, damping * 10.0)
        is_done |= (better & (gain < _SMALL_GAIN)) | (damping > _STUCK)
        if is_done.all():
            break
    return hypotheses, system


def _step(system: NormalEquations, damping: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Steps (S, 9) and (S, V, 6): views eliminated first, as in bundle adjustment."""
    matrix, gradient, eliminated, rest = without_views(system)
    diagonal = np.einsum("sii->si", matrix)
    damped = matrix + np.eye(SHARED) * ((diagonal + 1e-9) * damping[:, None])[:, None, :]
    shared = -solved(damped, gradient[..., None])[..., 0]
    tilt = np.linalg.norm(shared[:, AXIS], axis=-1, keepdims=True)
    shared[:, AXIS] *= np.minimum(1.0, _LONGEST_TILT / np.maximum(tilt, 1e-12))
    return shared, -(eliminated @ shared[:, None, :, None])[..., 0] - rest
