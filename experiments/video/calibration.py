"""Is a tracker's covariance honest, up to one factor that all sequences share?

A factor that is fitted on what it is judged by always fits; so each half of the sequences gets the
factor of the other half. What is left over tells how much the honesty differs between sequences.
"""

from collections.abc import Mapping, Sequence

import numpy as np

NEES_MEDIAN = 5.348
"""Median of a chi-squared distribution with the 6 degrees of freedom of a warp; its mean is 6."""


def calibrated(nees: Mapping[str, Sequence[float]]) -> np.ndarray:
    """All values of NEES by sequence, over the factor that makes the other half's median right.

    The halves take turns in the order of the names. Empty if one of them has no values.
    """
    halves = [
        np.array([value for name in sorted(nees)[start::2] for value in nees[name]])
        for start in (0, 1)
    ]
    if not all(len(half) and np.median(half) > 0 for half in halves):
        return np.empty(0)
    factors = [np.median(half) / NEES_MEDIAN for half in halves]
    return np.concatenate([halves[0] / factors[1], halves[1] / factors[0]])
