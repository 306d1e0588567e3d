"""What every tracker of warps reports of an image: an estimate and a status."""

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np


class Status(StrEnum):
    """What a tracker claims about its own answer."""

    SEARCHING = "searching"
    """No target yet."""
    TRACKING = "tracking"
    """The image supports the estimate."""
    UNCERTAIN = "uncertain"
    """The estimate coasts: hidden target, poor match or unusable image."""
    LOST = "lost"
    """The target is no longer where the estimate says."""


@dataclass(frozen=True, eq=False)
class WarpEstimate:
    """Where the template lies in one image."""

    warp: np.ndarray
    """(3, 3) Aff(2) element, template coordinates -> image [px]."""
    covariance: np.ndarray
    """(6, 6) in the tangent space at `warp` (right perturbation, template coordinates)."""
    ess: float = 1.0
    """Effective sample size of the weighted particles, from 1 to their number."""
    log_likelihood: float = 0.0
    """Log of the mean unnormalised weight: how well the image was predicted; -inf where no particle
    explains it."""
    ncc: float = 0.0
    """Normalised cross-correlation of template and visible patch, from -1 to 1."""
    visible_fraction: float = 0.0
    """Share of the template that lies in the image and is not hidden, from 0 to 1."""
    status: Status = Status.UNCERTAIN
    particles: np.ndarray = field(default_factory=lambda: np.empty((0, 3, 3)))
    """(n, 3, 3) warps after resampling; may be empty."""

    def __post_init__(self) -> None:
        for name in ("warp", "covariance", "particles"):
            array = np.array(getattr(self, name), float)
            array.setflags(write=False)
            object.__setattr__(self, name, array)
