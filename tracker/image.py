"""What a tracker is shown: an image with depth, of which only the part looked at need exist."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, TypeAlias

import numpy as np

Window: TypeAlias = tuple[slice, slice]
"""Rows and columns of an image, each a slice with a start and a stop within it."""


class CameraImage(Protocol):
    """One exposure of a calibrated RGB-D camera."""

    @property
    def shape_px(self) -> tuple[int, int]:
        """Rows and columns."""
        ...

    @property
    def time_s(self) -> float:
        """When it was exposed."""
        ...

    def crop(self, window: Window, /) -> tuple[np.ndarray, np.ndarray | None]:
        """A part of it: (h, w, 3) uint8 RGB and (h, w) depth along the optical axis [m].

        Depth is None where there is none.
        """
        ...


@dataclass(frozen=True, eq=False)
class ArrayImage:
    """A `CameraImage` that exists as a whole; one that is no picture has no pixels."""

    rgb: np.ndarray
    """(h, w, 3) uint8."""
    depth_m: np.ndarray | None
    """(h, w) along the optical axis; another shape counts as none."""
    time_s: float

    @cached_property
    def shape_px(self) -> tuple[int, int]:
        """See `CameraImage`."""
        is_picture = (
            isinstance(self.rgb, np.ndarray)
            and self.rgb.dtype == np.uint8
            and self.rgb.ndim == 3
            and self.rgb.shape[2] == 3
        )
        return self.rgb.shape[:2] if is_picture else (0, 0)

    def crop(self, window: Window, /) -> tuple[np.ndarray, np.ndarray | None]:
        """See `CameraImage`."""
        has_depth = isinstance(self.depth_m, np.ndarray) and self.depth_m.shape == self.shape_px
        return self.rgb[window], self.depth_m[window] if has_depth else None
