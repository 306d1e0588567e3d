"""The covariance of a pose and its landmarks, changed in place.

That of 200 landmarks does not fit into the cache near the core, and its copies would cost more than
the filter: so its upper half alone is kept, in memory that is taken once. Only entries (i, j) with
i <= j are read or written; what stands below the diagonal means nothing.

H has two rows a landmark, nonzero at the pose and at the landmark alone: dense products would be
mostly zeros, and arrays of small blocks are bound by overhead, hence compiled loops.
"""

from typing import Any

import numpy as np
import scipy.linalg.blas
import scipy.linalg.lapack
from numba import njit
from numpy.typing import NDArray

from tracker.bearing_only.landmarks import COORDINATES, INVERSE_DEPTH, POSE
from tracker.bearing_only.small_matrices import sandwich

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Seen = tuple[Array, Array, Index]
"""Derivatives of pixels by the pose (n, 2, 6) and by their landmark's numbers (n, 2, 6), zero where
it has but three, and the first of those numbers in the state (n,)."""


class JointCovariance:
    """A symmetric matrix (N, N) whose first six rows are those of the pose."""

    def __init__(self, pose: Array) -> None:
        """Starts with the covariance of the pose (6, 6) alone."""
        self._memory = np.array(pose, float).reshape(-1)
        self._size = POSE

    def __len__(self) -> int:
        return self._size

    @property
    def _upper(self) -> Array:
        """(N, N) view, of which entries (i, j) with i <= j count."""
        return self._memory[: self._size**2].reshape(self._size, self._size)

    @property
    def pose(self) -> Array:
        """(6, 6): a copy of the pose's part."""
        return _corner(self._upper, POSE)

    def blocks(self, index: Index) -> Array:
        """(..., k, k): the parts of rows and columns `index` (..., k)."""
        rows, columns = index[..., :, None], index[..., None, :]
        return self._upper[np.minimum(rows, columns), np.maximum(rows, columns)]

    def variances(self, index: Index) -> Array:
        """(...,): variances of the numbers at `index` (...,)."""
        return self._upper[index, index]

    def move_pose(self, F: Array, Q: Array) -> None:
        """The pose becomes F (6, 6) times itself plus noise of covariance Q (6, 6)."""
        P, pose = self._upper, self.pose
        P[:POSE, POSE:] = F @ P[:POSE, POSE:]
        P[:POSE, :POSE] = F @ pose @ F.T + Q

    def innovation_blocks(self, seen: Seen, noise_std: float) -> Array:
        """(n, 2, 2): what each pixel may deviate by, with noise of that deviation."""
        return _innovation_blocks(self._upper, *seen, noise_std**2)

    def correct(self, seen: Seen, residual: Array, noise_std: float) -> Array:
        """(N,) estimated error of the state by (2n,) residuals; P becomes P - P H' S^-1 H P.

        Raises numpy.linalg.LinAlgError where S is not positive definite; P is unchanged then.
        """
        P = self._upper
        HP, S = _project(P, *seen, noise_std**2)
        lapack: Any = scipy.linalg.lapack
        blas: Any = scipy.linalg.blas
        # An array in C order is its transpose to Fortran, so nothing is copied: L' is upper there.
        Lt, failed = lapack.dpotrf(S.T, lower=0, clean=0, overwrite_a=1)
        if failed:
            raise np.linalg.LinAlgError("the innovations' covariance is not positive definite")
        Wt = blas.dtrsm(1.0, Lt, HP.T, side=1, lower=0, overwrite_b=1)
        error = Wt @ blas.dtrsv(Lt, residual, lower=0, trans=1)
        blas.dsyrk(-1.0, Wt, beta=1.0, c=P.T, lower=1, overwrite_c=1)
        return np.asarray(error, np.float64)

    def to_coordinates(self, starts: Index, J: Array) -> None:
        """Landmarks (n,) of six numbers become J (n, 3, 6) times them; the last three mean nothing.

        They are to be left out by `keep` before anything else is asked.
        """
        _to_coordinates(self._upper, starts, J)

    def keep(self, kept: Index) -> None:
        """Leaves out all numbers but `kept` (k,), which ascend."""
        _select(self._memory, self._size, kept)
        self._size = len(kept)

    def append(self, J: Array, own: Array) -> None:
        """New numbers (m,): J (m, 6) times the error of the pose, plus errors of their own.

        Args:
            J: (m, 6).
            own: (n, k, k) covariances of n times k = m / n numbers.
        """
        N, M, pose = self._size, self._size + len(J), self.pose
        with_pose = J @ np.hstack([pose, self._upper[:POSE, POSE:]])
        if M**2 > len(self._memory):
            memory = np.empty((2 * M) ** 2)
            memory[: N**2] = self._memory[: N**2]
            self._memory = memory
        _widen(self._memory, N, M)
        self._size, index = M, np.arange(N, M).reshape(own.shape[:2])
        P = self._upper
        P[:N, N:] = with_pose.T
        P[N:, N:] = J @ pose @ J.T
        P[index[:, :, None], index[:, None, :]] += own


@njit(cache=True, error_model="numpy")
def _widen(memory: np.ndarray, old: int, new: int) -> None:
    """Lays the upper half of (old, old) out anew as the first part of (new, new), new >= old."""
    row = np.empty(old)
    for i in range(old - 1, -1, -1):
        length = old - i
        _copy(row, memory[i * old + i :], length)
        _copy(memory[i * new + i :], row, length)


@njit(cache=True, error_model="numpy")
def _select(memory: np.ndarray, size: int, kept: np.ndarray) -> None:
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
def _corner(P: np.ndarray, size: int) -> np.ndarray:
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
def _innovation_blocks(
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
def _project(
    P: np.ndarray, by_pose: np.ndarray, by_feature: np.ndarray, starts: np.ndarray, variance: float
) -> tuple[np.ndarray, np.ndarray]:
    """H P (2n, N), and the lower half of S = H P H' + R (2n, 2n); as `_innovation_blocks`."""
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
def _to_coordinates(P: np.ndarray, starts: np.ndarray, J: np.ndarray) -> None:
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
