"""The affine group Aff(2) of the plane, on stacked arrays.

An element is a (..., 3, 3) matrix `[[A, t], [0, 0, 1]]` with det A > 0, in float64. Its tangent
vector `(..., 6)` lists scale, aspect, rotation, shear, x, y, in the order of [IGPF2021] Eq (5):

    hat(e) = [[e1 + e2, e4 - e3, e5], [e4 + e3, e1 - e2, e6], [0, 0, 0]],

and `vee` is the inverse of `hat`. Perturbations act on the right: `X exp(hat(e))`, so `e` lives in
template coordinates. Functions broadcast over leading axes. Compiled closed forms replace the
general matrix exponential and logarithm; both are smooth through the identity. Elements without a
principal logarithm give NaN, so check `is_valid` before `log` where particles may have strayed.
"""

from typing import Any

import numpy as np

from tracker.affine import aff2_loops

_loops: Any = aff2_loops  # the result of a generalised ufunc has no type

_quietly = np.errstate(all="ignore")
"""An element without a logarithm gives NaN, not a warning."""
_TANGENT = np.empty(6)
"""An argument of which only the shape counts: that of the result of a compiled function."""


@_quietly
def is_valid(X: np.ndarray, det_range: tuple[float, float] = (1e-9, 1e9)) -> np.ndarray:
    """(...,) True where X is finite and det A lies inside `det_range`."""
    return _loops.is_valid(X, *det_range)


def inverse(X: np.ndarray) -> np.ndarray:
    """(..., 3, 3) group inverse."""
    Y = np.zeros_like(X, dtype=float)
    det = X[..., 0, 0] * X[..., 1, 1] - X[..., 0, 1] * X[..., 1, 0]
    Y[..., 0, 0] = X[..., 1, 1] / det
    Y[..., 1, 1] = X[..., 0, 0] / det
    Y[..., 0, 1] = -X[..., 0, 1] / det
    Y[..., 1, 0] = -X[..., 1, 0] / det
    Y[..., :2, 2] = -np.einsum("...ij,...j->...i", Y[..., :2, :2], X[..., :2, 2])
    Y[..., 2, 2] = 1.0
    return Y


def exp(e: np.ndarray) -> np.ndarray:
    """(..., 3, 3) group elements of tangent vectors (..., 6)."""
    return perturb(np.eye(3), e)


def log(X: np.ndarray) -> np.ndarray:
    """(..., 6) principal logarithm of group elements; NaN where there is none."""
    return difference(np.eye(3), X)


@_quietly
def difference(X: np.ndarray, Y: np.ndarray) -> np.ndarray:
    """(..., 6) tangent vector `vee log(X^-1 Y)` that leads from X to Y."""
    return _loops.difference(X, Y, _TANGENT)


@_quietly
def perturb(X: np.ndarray, e: np.ndarray) -> np.ndarray:
    """(..., 3, 3) right perturbation `X exp(hat(e))`. [IGPF2021] Eq (18)."""
    return _loops.perturb(X, e)


@_quietly
def advance(X: np.ndarray, Y: np.ndarray, share: float) -> np.ndarray:
    """(..., 3, 3) elements Y moved on by a share of the tangent vectors from X to Y."""
    return _loops.advance(X, Y, share)


def mean(X: np.ndarray, weights: np.ndarray, iterations: int = 2) -> np.ndarray:
    """(3, 3) intrinsic mean of elements (n, 3, 3) under weights (n,) that sum to one.

    Starts at the heaviest element and repeats `Xbar <- Xbar exp(sum w log(Xbar^-1 X))`; a plain
    average of matrices would shrink rotations. Elements without a logarithm there (some that are
    half a turn away) count as if they were at the mean. [Kwon2010]
    """
    Xbar = np.empty((3, 3))
    _loops.mean(np.ascontiguousarray(X, float), weights, iterations, Xbar)
    return Xbar


def covariance(X: np.ndarray, weights: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """(6, 6) weighted sum of outer products of the tangent vectors from `centre` (3, 3) to X.

    Elements of X (n, 3, 3) without a logarithm there count as if they were at `centre`.
    """
    result = np.empty((6, 6))
    _loops.covariance(np.ascontiguousarray(X, float), weights, centre, result)
    return result


@_quietly
def polar(X: np.ndarray) -> np.ndarray:
    """(..., 6) affine parameters: log scale, aspect, angle [rad], shear, x, y.

    The 2x2 block is split as `R(angle) exp(symmetric)`; x and y are those of the matrix.
    """
    return _loops.polar(X, _TANGENT)


@_quietly
def from_polar(p: np.ndarray) -> np.ndarray:
    """(..., 3, 3) warps of affine parameters (..., 6); inverse of `polar`."""
    return _loops.from_polar(p, np.eye(3))


def similarity(scale: float, angle_rad: float, centre: np.ndarray) -> np.ndarray:
    """(3, 3) warp that scales, rotates and then moves the origin to `centre` (2,)."""
    p = np.zeros(6)
    p[0], p[2], p[4:] = np.log(scale), angle_rad, centre
    return from_polar(p)
