"""Who the landmarks in the state are, where their numbers stand, and how often they were found."""

import numpy as np
from numpy.typing import NDArray

POSE = 6
"""Numbers of the pose, the first of the state."""
INVERSE_DEPTH, COORDINATES = 6, 3
"""Numbers of a landmark in the state."""


class LandmarkTable:
    """One row for each landmark, in the order of the state."""

    def __init__(self) -> None:
        self.ids = np.empty(0, np.int64)
        self.sizes = np.empty(0, np.int64)
        """Numbers of each landmark."""
        self.starts = np.empty(0, np.int64)
        """The first of each landmark's numbers in the state."""
        self.tried = np.empty(0, np.int64)
        """Number of images in which each landmark was measured."""
        self.found = np.empty(0, np.int64)
        """Number of these in which the measurement was believed."""
        self.last_seen = np.empty(0, np.int64)
        """Iteration of the last measurement."""
        self._order = np.empty(0, np.int64)

    def __len__(self) -> int:
        return len(self.ids)

    def rows_of(self, ids: NDArray[np.int64]) -> NDArray[np.int64]:
        """(n,): the row of each id; -1 for an unknown one."""
        if not len(self):
            return np.full(len(ids), -1)
        place = np.searchsorted(self.ids, ids, sorter=self._order)
        rows = self._order[np.minimum(place, len(self) - 1)]
        return np.where(self.ids[rows] == ids, rows, -1)

    def indices(self, rows: NDArray[np.int64], size: int) -> NDArray[np.int64]:
        """(n, size): where the numbers of landmarks of that size stand in the state."""
        return self.starts[rows][:, None] + np.arange(size)

    def add(self, ids: NDArray[np.int64], iteration: int) -> None:
        """New landmarks at the end, by inverse depth."""
        n = len(ids)
        self.ids = np.concatenate([self.ids, ids])
        self.sizes = np.concatenate([self.sizes, np.full(n, INVERSE_DEPTH)])
        self.tried = np.concatenate([self.tried, np.ones(n, np.int64)])
        self.found = np.concatenate([self.found, np.ones(n, np.int64)])
        self.last_seen = np.concatenate([self.last_seen, np.full(n, iteration)])
        self._place()

    def to_coordinates(self, rows: NDArray[np.int64]) -> None:
        """Landmarks (n,) have three numbers from now on."""
        self.sizes[rows] = COORDINATES
        self._place()

    def keep(self, is_kept: NDArray[np.bool_]) -> None:
        """Forgets the others."""
        for name in ("ids", "sizes", "tried", "found", "last_seen"):
            setattr(self, name, getattr(self, name)[is_kept])
        self._place()

    def _place(self) -> None:
        self._order = np.argsort(self.ids)
        self.starts = POSE + np.cumsum(self.sizes) - self.sizes
