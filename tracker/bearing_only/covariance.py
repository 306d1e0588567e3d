"""Products with the covariance of a large state, where each measurement touches a few numbers.

H has two rows a landmark, nonzero at the pose and at the landmark alone: dense products would be
mostly zeros, and arrays of small blocks are bound by overhead. What is dense goes to BLAS in place,
since the covariance of 200 landmarks does not fit into the cache near the core.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.linalg.blas
import scipy.linalg.lapack
from numba import njit
from numpy.typing import NDArray

from tracker.bearing_only.landmarks import INVERSE_DEPTH

Array = NDArray[np.float64]

POSE = 6
"""Numbers of the pose, the first of the state."""

_BLOCK = 64


@njit(cache=True)
def innovation_blocks(
    by_pose: np.ndarray, by_feature: np.ndarray, starts: np.ndarray, P: np.ndarray, noise_std: float
) -> np.ndarray:
    """(n, 2, 2): what each landmark's pixel may deviate by, all else left aside.

    Args:
        by_pose: (n, 2, 6) derivatives of each pixel by the pose.
        by_feature: (n, 2, 6) derivatives by the landmark's numbers; zero where it has but three.
        starts: (n,) the first of each landmark's numbers in the state.
        P: (N, N) covariance, symmetric.
        noise_std: Deviation of each pixel's coordinates.
    """
    blocks = np.empty((len(starts), 2, 2))
    H, place = np.empty((2, POSE + INVERSE_DEPTH)), np.arange(POSE + INVERSE_DEPTH)
    for i in range(len(starts)):
        H[:, :POSE], H[:, POSE:] = by_pose[i], by_feature[i]
        for j in range(INVERSE_DEPTH):
            place[POSE + j] = min(starts[i] + j, len(P) - 1)  # beyond it the derivatives are zero
        block = blocks[i]
        block[:] = 0.0
        for j in range(len(place)):
            for k in range(len(place)):
                covariance = P[place[j], place[k]]
                for a in range(2):
                    for b in range(2):
                        block[a, b] += H[a, j] * covariance * H[b, k]
        block[0, 0] += noise_std**2
        block[1, 1] += noise_std**2
    return blocks


def project(
    by_pose: Array, by_feature: Array, starts: NDArray[np.int64], P: Array, noise_std: float
) -> tuple[Array, Array]:
    """H P (2n, N), and the lower half of S = H P H' + R (2n, 2n); as `innovation_blocks`."""
    n = len(starts)
    HP, S = np.empty((2 * n, len(P))), np.zeros((2 * n, 2 * n))
    sizes = np.minimum(INVERSE_DEPTH, len(P) - starts)
    _rows(by_pose, by_feature, starts, sizes, P, HP)
    _square(by_pose, by_feature, starts, sizes, HP, S)
    S[np.arange(2 * n), np.arange(2 * n)] += noise_std**2
    return HP, S


def correct(P: Array, HP: Array, S: Array, residual: Array) -> Array:
    """(N,) estimated error of the state; P becomes P - P H' S^-1 H P, HP is used up.

    Raises numpy.linalg.LinAlgError where S is not positive definite, and ValueError where P could
    not be changed in place.

    Args:
        P: (N, N) covariance in C order, changed in place.
        HP: (m, N), overwritten.
        S: (m, m), of which the lower half counts; overwritten.
        residual: (m,).
    """
    if not P.flags.c_contiguous:  # BLAS would change a copy, and nobody would notice
        raise ValueError("P must be in C order")
    lapack: Any = scipy.linalg.lapack
    blas: Any = scipy.linalg.blas
    # A C-ordered array is its transpose to Fortran, so nothing is copied: L' is upper there.
    Lt, failed = lapack.dpotrf(S.T, lower=0, clean=0, overwrite_a=1)
    if failed:
        raise np.linalg.LinAlgError("the innovations' covariance is not positive definite")
    Wt = blas.dtrsm(1.0, Lt, HP.T, side=1, lower=0, overwrite_b=1)
    error = Wt @ blas.dtrsv(Lt, residual, lower=0, trans=1)
    blas.dsyrk(-1.0, Wt, beta=1.0, c=P.T, lower=1, overwrite_c=1)
    _mirror(P)
    return np.asarray(error, np.float64)


@njit(cache=True)
def selected(P: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """(k, k): rows and columns `kept` (k,) of P; index arrays take a multiple of the time."""
    k = len(kept)
    part = np.empty((k, k))
    for i in range(k):
        row = P[kept[i]]
        for j in range(k):
            part[i, j] = row[kept[j]]
    return part


@njit(cache=True)
def _rows(
    by_pose: np.ndarray,
    by_feature: np.ndarray,
    starts: np.ndarray,
    sizes: np.ndarray,
    P: np.ndarray,
    HP: np.ndarray,
) -> None:
    """Fills H P: each row is a sum of few rows of P."""
    for i in range(len(starts)):
        for a in range(2):
            row = HP[2 * i + a]
            row[:] = by_pose[i, a, 0] * P[0]
            for j in range(1, POSE):
                _add(row, by_pose[i, a, j], P[j])
            for j in range(sizes[i]):
                if by_feature[i, a, j] != 0.0:
                    _add(row, by_feature[i, a, j], P[starts[i] + j])


@njit(cache=True)
def _add(row: np.ndarray, factor: float, other: np.ndarray) -> None:
    for k in range(len(row)):
        row[k] += factor * other[k]


@njit(cache=True)
def _square(
    by_pose: np.ndarray,
    by_feature: np.ndarray,
    starts: np.ndarray,
    sizes: np.ndarray,
    HP: np.ndarray,
    S: np.ndarray,
) -> None:
    """Fills the lower half of H P H'."""
    for row in range(len(HP)):
        for i in range(row // 2 + 1):
            for a in range(2):
                total = 0.0
                for j in range(POSE):
                    total += HP[row, j] * by_pose[i, a, j]
                for j in range(sizes[i]):
                    total += HP[row, starts[i] + j] * by_feature[i, a, j]
                S[row, 2 * i + a] = total


@njit(cache=True)
def _mirror(P: np.ndarray) -> None:
    """Copies the upper half of P (N, N) to the lower one, block by block for the cache."""
    N = len(P)
    for top in range(0, N, _BLOCK):
        for left in range(top, N, _BLOCK):
            for i in range(top, min(top + _BLOCK, N)):
                for j in range(max(left, i + 1), min(left + _BLOCK, N)):
                    P[j, i] = P[i, j]
