"""Where the state lives and how it moves: the group Aff(2), or a vector of six parameters.

Both store warps (n, 3, 3) outside and offer the same operations, so the filter does not know
which it runs on. Tangent vectors list scale, aspect, rotation, shear, x, y; translations are in
template units in both.
"""

from typing import Protocol

import numpy as np

from tracker.affine import aff2


class StateSpace(Protocol):
    """A space of warps with a retraction and its inverse."""

    def perturb(self, warps: np.ndarray, e: np.ndarray, /) -> np.ndarray:
        """(n, 3, 3) warps moved by tangent vectors e (n, 6)."""
        ...

    def difference(self, start: np.ndarray, end: np.ndarray, /) -> np.ndarray:
        """(n, 6) tangent vector from `start` to `end`; inverse of `perturb`."""
        ...

    def advance(self, start: np.ndarray, end: np.ndarray, share: float, /) -> np.ndarray:
        """(n, 3, 3) `end` moved on by a share of the tangent vectors that lead there."""
        ...

    def mean(self, warps: np.ndarray, weights: np.ndarray, /) -> np.ndarray:
        """(3, 3) mean of warps (n, 3, 3) under weights (n,) that sum to one."""
        ...


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

    def advance(self, start: np.ndarray, end: np.ndarray, share: float) -> np.ndarray:
        """The rates of the parameters are kept."""
        return self.perturb(end, share * self.difference(start, end))

    def mean(self, warps: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Mean of the parameters; angles are averaged around that of the heaviest warp."""
        Xbar = warps[int(np.argmax(weights))]
        for _ in range(2):  # translations count in units of the warp that they start from
            Xbar = self.perturb(Xbar, weights @ self.difference(Xbar, warps))
        return Xbar


STATE_SPACES: dict[str, StateSpace] = {"group": aff2, "vector": AffineVector()}
"""By name: the group has the right perturbations and the intrinsic mean of [IGPF2021] Eqs (8) and
(18), and keeps the body's velocity."""


def moments(
    space: StateSpace, warps: np.ndarray, weights: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Weighted mean (3, 3), and covariance (6, 6) in the tangent space of Aff(2) at it."""
    Xbar = space.mean(warps, weights)
    return Xbar, aff2.covariance(warps, weights, Xbar)
