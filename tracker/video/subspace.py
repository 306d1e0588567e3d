"""Ways in which a target may look different: an incremental principal-component basis.

Sequential Karhunen-Loeve update with forgetting, as in the incremental visual tracker [Ross2008].
"""

import math
from dataclasses import dataclass

import numpy as np

from tracker.checks import require_count, require_share


@dataclass(frozen=True)
class SubspaceConfig:
    """Size and memory of the basis."""

    rank: int = 4
    """Components kept; a large basis explains the background as well."""
    batch: int = 5
    """Patches gathered before the basis is updated."""
    forgetting: float = 0.95
    """Factor on the old singular values at each update."""

    def __post_init__(self) -> None:
        require_count(self, "rank", "batch")
        require_share(self, "forgetting")


class Subspace:
    """The main variations of the normalised patches seen so far, around their running mean."""

    def __init__(self, config: SubspaceConfig, first: np.ndarray) -> None:
        """Begins with the patch `first` (n,) as the mean and an empty basis."""
        self._config = config
        self._mean = first.astype(float)
        self._count = 1.0
        self._singular_values = np.zeros(0)
        self._waiting: list[np.ndarray] = []
        self.basis = np.empty((0, len(first)), np.float32)
        """(k, n) orthonormal rows, each also orthogonal to a constant patch."""

    def add(self, patch: np.ndarray) -> None:
        """Takes a patch (n,) of zero mean; every `batch` of them the basis is new."""
        self._waiting.append(patch.astype(float))
        if len(self._waiting) == self._config.batch:
            self._merge(np.stack(self._waiting))
            self._waiting.clear()

    def _merge(self, patches: np.ndarray) -> None:
        """One SVD of old basis, centred patches and shift of the mean. [Ross2008] section 3.1."""
        old, new = self._config.forgetting * self._count, float(len(patches))
        batch_mean = patches.mean(axis=0)
        shift = math.sqrt(old * new / (old + new)) * (batch_mean - self._mean)
        weighted = (self._config.forgetting * self._singular_values)[:, None] * self.basis
        stack = np.vstack([weighted, patches - batch_mean, shift])
        _, singular_values, rows = np.linalg.svd(stack, full_matrices=False)
        known = singular_values > 1e-6 * max(singular_values[0], 1e-12)
        kept = slice(min(self._config.rank, int(known.sum())))
        self._singular_values = singular_values[kept]
        self.basis = rows[kept].astype(np.float32)
        self._mean += new / (old + new) * (batch_mean - self._mean)
        self._count = old + new
