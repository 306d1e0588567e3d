"""Gauss-Newton ascent of the likelihood of one image, without a prior."""

import numpy as np

from tracker.affine import aff2
from tracker.affine.likelihood import Observation

_DAMPING = 30.0
"""Added to the information of each direction: one that the template does not show stays put."""
_STEP_LIMIT = 0.3


def climb(observation: Observation, warps: np.ndarray, iterations: int) -> np.ndarray:
    """(k, 3, 3) warps moved to the nearest maxima of the likelihood."""
    for _ in range(iterations):
        gradient, information = observation.linearise(warps)
        damped = information + _DAMPING * np.eye(6)
        step = np.linalg.solve(damped, gradient[..., None])[..., 0]
        warps = aff2.perturb(warps, np.clip(np.nan_to_num(step), -_STEP_LIMIT, _STEP_LIMIT))
    return warps
