"""Where the state lives and how it moves: the group Aff(2), or a vector of six parameters.

Both store warps (n, 3, 3) outside and offer the same four operations, so the filter does not know
which it runs on. Tangent vectors list scale, aspect, rotation, shear, x, y; translations are in
template units in both.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from tracker import aff2


class StateSpace(Protocol):
    """A space of warps with a retraction and its inverse."""

    def perturb(self, warps: np.ndarray, e: np.ndarray) -> np.ndarray:
        """(n, 3, 3) warps moved by tangent vectors e (n, 6)."""
        ...

    def difference(self, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        """(n, 6) tangent vector from `start` to `end`; inverse of `perturb`."""
        ...

    def log_volume(self, e: np.ndarray) -> np.ndarray:
        """(n,) log of the volume change of `perturb` at e."""
        ...


class AffineGroup:
    """Aff(2) with right perturbations. [IGPF2021] Eqs (8), (18)."""

    def perturb(self, warps: np.ndarray, e: np.ndarray) -> np.ndarray:
        """X exp(hat(e))."""
        return aff2.perturb(warps, e)

    def difference(self, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        """vee log(start^-1 end)."""
        return aff2.difference(start, end)

    def log_volume(self, e: np.ndarray) -> np.ndarray:
        """ln |det Jr(e)|."""
        return aff2.log_det_right_jacobian(e)


class AffineVector:
    """Six affine parameters with additive noise, as in conventional particle filters.

    The parameters are those of `aff2.polar`; translations run along the image axes.
    """

    def perturb(self, warps: np.ndarray, e: np.ndarray) -> np.ndarray:
        """Adds e to the parameters, translations scaled to pixels."""
        p = aff2.polar(warps)
        unit_px = np.exp(p[..., :1])
        p[..., :4] += e[..., :4]
        p[..., 4:] += unit_px * e[..., 4:]
        return aff2.from_polar(p)

    def difference(self, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        """Difference of the parameters, the angle in (-pi, pi]."""
        p = aff2.polar(start)
        e = aff2.polar(end) - p
        e[..., 2] = np.remainder(e[..., 2] + np.pi, 2 * np.pi) - np.pi
        e[..., 4:] /= np.exp(p[..., :1])
        return e

    def log_volume(self, e: np.ndarray) -> np.ndarray:
        """Zero: a vector space is flat."""
        return np.zeros(e.shape[:-1])


STATE_SPACES: dict[str, StateSpace] = {"group": AffineGroup(), "vector": AffineVector()}


def moments(
    space: StateSpace, warps: np.ndarray, weights: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Weighted mean (3, 3), and covariance (6, 6) in the tangent space of Aff(2) at it.

    The mean starts at the heaviest warp and is iterated on the tangent space. Warps without a
    logarithm there (some that are half a turn away) count as if they were at the mean.
    """
    Xbar = warps[int(np.argmax(weights))]
    for _ in range(3):
        Xbar = space.perturb(Xbar, weights @ _finite(space.difference(Xbar, warps)))
    e = _finite(aff2.difference(Xbar, warps))
    return Xbar, np.einsum("n,ni,nj->ij", weights, e, e)


def _finite(e: np.ndarray) -> np.ndarray:
    """Tangent vectors (n, 6), zero where one is not finite."""
    return np.where(np.isfinite(e).all(axis=1, keepdims=True), e, 0.0)
