"""The covariance of a pose and its landmarks, changed in place.

That of 200 landmarks does not fit into the cache near the core, and its copies would cost more than
the filter: so its upper half alone is kept, in memory that is taken once.
"""

from typing import Any

import numpy as np
import scipy.linalg.blas
import scipy.linalg.lapack
from numpy.typing import NDArray

from tracker.bearing_only import covariance_loops as loops
from tracker.bearing_only.landmarks import POSE

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
        return loops.corner(self._upper, POSE)

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
        return loops.innovation_blocks(self._upper, *seen, noise_std**2)

    def correct(self, seen: Seen, residual: Array, noise_std: float) -> Array:
        """(N,) estimated error of the state by (2n,) residuals; P becomes P - P H' S^-1 H P.

        Raises numpy.linalg.LinAlgError where S is not positive definite; P is unchanged then.
        """
        P = self._upper
        HP, S = loops.project(P, *seen, noise_std**2)
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
        loops.to_coordinates(self._upper, starts, J)

    def keep(self, kept: Index) -> None:
        """Leaves out all numbers but `kept` (k,), which ascend."""
        loops.select(self._memory, self._size, kept)
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
        loops.widen(self._memory, N, M)
        self._size, index = M, np.arange(N, M).reshape(own.shape[:2])
        P = self._upper
        P[:N, N:] = with_pose.T
        P[N:, N:] = J @ pose @ J.T
        P[index[:, :, None], index[:, None, :]] += own
