"""What a tracker is shown: an image with depth, of which only the part looked at need exist."""

from dataclasses import dataclass
from typing import Protocol, TypeAlias, cast

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

    rgb: object
    """(h, w, 3) uint8."""
    depth_m: object
    """(h, w) along the optical axis; another shape counts as none."""
    time_s: float = 0.0

    @property
    def shape_px(self) -> tuple[int, int]:
        """See `CameraImage`."""
        rgb = _array(self.rgb)
        is_picture = rgb.dtype == np.uint8 and rgb.ndim == 3 and rgb.shape[2] == 3
        return rgb.shape[:2] if is_picture else (0, 0)

    def crop(self, window: Window, /) -> tuple[np.ndarray, np.ndarray | None]:
        """See `CameraImage`."""
        depth_m = _array(self.depth_m)
        has_depth = depth_m.shape == self.shape_px
        return _array(self.rgb)[window], depth_m[window] if has_depth else None


def _array(value: object) -> np.ndarray:
    """The value, or an empty array if it is none."""
    return cast(np.ndarray, value) if isinstance(value, np.ndarray) else np.empty(0)
