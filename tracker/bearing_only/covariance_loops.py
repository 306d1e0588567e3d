"""Compiled loops over a covariance of which the upper half is kept.

H has two rows a landmark, nonzero at the pose and at the landmark alone: dense products would be
mostly zeros, and arrays of small blocks are bound by overhead. Only entries (i, j) with i <= j are
read or written; what stands below the diagonal means nothing.
"""

import numpy as np
from numba import njit

from tracker.bearing_only.landmarks import COORDINATES, INVERSE_DEPTH, POSE
from tracker.bearing_only.small_matrices import sandwich


@njit(cache=True, error_model="numpy")
def widen(memory: np.ndarray, old: int, new: int) -> None:
    """Lays the upper half of (old, old) out anew as the first part of (new, new), new >= old."""
    row = np.empty(old)
    for i in range(old - 1, -1, -1):
        length = old - i
        _copy(row, memory[i * old + i :], length)
        _copy(memory[i * new + i :], row, length)


@njit(cache=True, error_model="numpy")
def select(memory: np.ndarray, size: int, kept: np.ndarray) -> None:
    """Leaves of (size, size) the rows and columns `kept` (k,), ascending, as (k, k)."""
    k, row = len(kept), np.empty(size)
    end = np.empty(k, np.int64)  # of the run of neighbours: whole runs are copied fast
    for i in range(k - 1, -1, -1):
        end[i] = end[i + 1] if i + 1 < k and kept[i + 1] == kept[i] + 1 else i + 1
    for i in range(k):
        first = kept[i]
        _copy(row[first:], memory[first * size + first :], size - first)
        j = i
        while j < k:
            _copy(memory[i * k + j :], row[kept[j] :], end[j] - j)
            j = end[j]


@njit(cache=True, error_model="numpy")
def corner(P: np.ndarray, size: int) -> np.ndarray:
    """(size, size): a copy of the first rows and columns, with both halves."""
    part = np.empty((size, size))
    for i in range(size):
        for j in range(i, size):
            part[i, j] = part[j, i] = P[i, j]
    return part


@njit(cache=True, error_model="numpy")
def _copy(target: np.ndarray, source: np.ndarray, count: int) -> None:
    for j in range(count):
        target[j] = source[j]


@njit(cache=True, error_model="numpy")
def innovation_blocks(
    P: np.ndarray, by_pose: np.ndarray, by_feature: np.ndarray, starts: np.ndarray, variance: float
) -> np.ndarray:
    """(n, 2, 2): what each landmark's pixel may deviate by, all else left aside.

    Args:
        P: (N, N).
        by_pose: (n, 2, 6) derivatives of each pixel by the pose.
        by_feature: (n, 2, 6) derivatives by the landmark's numbers; zero where it has but three.
        starts: (n,) the first of each landmark's numbers in the state.
        variance: Of each pixel's coordinates.
    """
    blocks = np.empty((len(starts), 2, 2))
    width = POSE + INVERSE_DEPTH
    H, place = np.empty((2, width)), np.arange(width)
    for i in range(len(starts)):
        H[:, :POSE], H[:, POSE:] = by_pose[i], by_feature[i]
        for j in range(INVERSE_DEPTH):
            place[POSE + j] = min(starts[i] + j, len(P) - 1)  # beyond it the derivatives are zero
        uu = vv = variance
        uv = 0.0
        for j in range(width):
            u = v = 0.0
            for k in range(width):
                covariance = P[min(place[j], place[k]), max(place[j], place[k])]
                u += covariance * H[0, k]
                v += covariance * H[1, k]
            uu += H[0, j] * u
            uv += H[0, j] * v
            vv += H[1, j] * v
        blocks[i, 0, 0], blocks[i, 1, 1] = uu, vv
        blocks[i, 0, 1] = blocks[i, 1, 0] = uv
    return blocks


@njit(cache=True, error_model="numpy")
def project(
    P: np.ndarray, by_pose: np.ndarray, by_feature: np.ndarray, starts: np.ndarray, variance: float
) -> tuple[np.ndarray, np.ndarray]:
    """H P (2n, N), and the lower half of S = H P H' + R (2n, 2n); as `innovation_blocks`."""
    n, N = len(starts), len(P)
    HP, S = np.empty((2 * n, N)), np.zeros((2 * n, 2 * n))
    of_pose = np.empty((POSE, N))
    for k in range(POSE):
        of_pose[k, :k] = P[:k, k]
        of_pose[k, k:] = P[k, k:]
    for i in range(n):
        u, v = HP[2 * i], HP[2 * i + 1]
        u[:] = v[:] = 0.0
        for k in range(POSE):
            _add(u, v, by_pose[i, 0, k], by_pose[i, 1, k], of_pose[k])
        for k in range(starts[i], min(starts[i] + INVERSE_DEPTH, N)):
            of_u, of_v = by_feature[i, 0, k - starts[i]], by_feature[i, 1, k - starts[i]]
            if of_u != 0.0 or of_v != 0.0:
                _add(u, v, of_u, of_v, P[:k, k])
                _add(u[k:], v[k:], of_u, of_v, P[k, k:])
    for row in range(2 * n):
        for i in range(row // 2 + 1):
            start = starts[i]
            for a in range(2):
                total = 0.0
                for k in range(POSE):
                    total += HP[row, k] * by_pose[i, a, k]
                for k in range(min(INVERSE_DEPTH, N - start)):
                    total += HP[row, start + k] * by_feature[i, a, k]
                S[row, 2 * i + a] = total
        S[row, row] += variance
    return HP, S


@njit(cache=True, error_model="numpy")
def _add(u: np.ndarray, v: np.ndarray, of_u: float, of_v: float, row: np.ndarray) -> None:
    for j in range(len(row)):
        u[j] += of_u * row[j]
        v[j] += of_v * row[j]


@njit(cache=True, error_model="numpy")
def to_coordinates(P: np.ndarray, starts: np.ndarray, J: np.ndarray) -> None:
    """Puts the covariance of J (n, 3, 6) times a landmark's numbers in the place of its first."""
    old, new = np.empty(INVERSE_DEPTH), np.empty(COORDINATES)
    block = np.empty((INVERSE_DEPTH, INVERSE_DEPTH))
    for i in range(len(starts)):
        start = starts[i]
        end = start + INVERSE_DEPTH
        for j in range(len(P)):
            if start <= j < end:
                continue
            for k in range(INVERSE_DEPTH):
                old[k] = P[j, start + k] if j < start else P[start + k, j]
            for c in range(COORDINATES):
                new[c] = 0.0
                for k in range(INVERSE_DEPTH):
                    new[c] += J[i, c, k] * old[k]
            for c in range(COORDINATES):
                if j < start:
                    P[j, start + c] = new[c]
                else:
                    P[start + c, j] = new[c]
        for k in range(INVERSE_DEPTH):
            for m in range(k, INVERSE_DEPTH):
                block[k, m] = block[m, k] = P[start + k, start + m]
        of_coordinates = sandwich(J[i], block)
        for c in range(COORDINATES):
            for d in range(c, COORDINATES):
                P[start + c, start + d] = of_coordinates[c, d]
