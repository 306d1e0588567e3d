"""What every image tracker takes and gives: the `Tracker` protocol and `WarpEstimate`."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Protocol, runtime_checkable

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
class ResamplingTrace:
    """What a resampling started from; what it left are the estimate's particles."""

    warps: np.ndarray
    """(n, 3, 3) before it."""
    weights: np.ndarray
    """(n,) of these, with sum one."""
    parents: np.ndarray
    """(n,) which of these each particle afterwards comes from."""


@dataclass(frozen=True, eq=False)
class WarpEstimate:
    """Where the template lies in one image."""

    warp: np.ndarray
    """(3, 3) Aff(2) element, template coordinates -> image [px]."""
    covariance: np.ndarray
    """(6, 6) in the tangent space at `warp` (right perturbation, template coordinates)."""
    ess: float
    """Effective sample size of the weighted particles, from 1 to their number."""
    log_likelihood: float
    """Log of the mean unnormalised weight: how well the image was predicted."""
    ncc: float
    """Normalised cross-correlation of template and visible patch, from -1 to 1."""
    visible_fraction: float
    """Share of the template that lies in the image and is not hidden, from 0 to 1."""
    status: Status
    particles: np.ndarray = field(default_factory=lambda: np.empty((0, 3, 3)))
    """(n, 3, 3) warps after resampling; may be empty."""
    resampling: ResamplingTrace | None = None
    """None where nothing was resampled."""

    def __post_init__(self) -> None:
        for name in ("warp", "covariance", "particles"):
            array = np.array(getattr(self, name), float)
            array.setflags(write=False)
            object.__setattr__(self, name, array)


@runtime_checkable
class Tracker(Protocol):
    """Follows one template through a sequence of grey images."""

    def start(self, warp: np.ndarray, time_s: float) -> None:
        """Takes `warp` (3, 3), template -> image [px], as the truth at `time_s`."""
        ...

    def update(
        self, image: np.ndarray, time_s: float, visibility: np.ndarray | None = None
    ) -> WarpEstimate:
        """Estimates the warp in `image` (h, w) at `time_s`.

        `visibility` (h, w) is 1 where a pixel may show the target and 0 where it cannot; None
        means everywhere.
        """
        ...
