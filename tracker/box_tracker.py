"""The interface of video trackers: a box on the first image, boxes on those after.

Boxes are (x, y, w, h) in pixels, x and y of the upper left corner counted from 0.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tracker.base import WarpEstimate


@dataclass(frozen=True, eq=False)
class BoxEstimate:
    """Where a tracker believes its target to be on one image."""

    box: np.ndarray
    """(4,) x, y, w, h [px]; the last known one where the target is not found."""
    affine: WarpEstimate | None = None
    """What a tracker of warps knows beyond the box: the warp from template coordinates (origin at
    the centre of the first box, unit sqrt(w h) of it) to pixels, its covariance, its particles."""


class BoxTracker(Protocol):
    """Follows one target through a video."""

    def start(self, image: np.ndarray, box: np.ndarray) -> None:
        """Takes the target in `box` (4,) of the BGR `image` (h, w, 3).

        Raises ValueError where there is nothing to track: no area, no texture.
        """
        ...

    def update(self, image: np.ndarray) -> BoxEstimate:
        """The target in the next BGR image (h, w, 3)."""
        ...


def warp_of_box(box: np.ndarray) -> np.ndarray:
    """(3, 3) warp that lays a template of the box's proportions upright over the box."""
    x, y, w, h = (float(v) for v in box)
    unit_px = (w * h) ** 0.5
    return np.array([[unit_px, 0, x + (w - 1) / 2], [0, unit_px, y + (h - 1) / 2], [0, 0, 1.0]])


def box_of_warp(warp: np.ndarray, size: tuple[float, float]) -> np.ndarray:
    """(4,) axis-aligned box of the ellipse that the warped template inscribes.

    Unlike the box of the corners it does not grow with a rotation; for an unrotated template, or
    one turned by a right angle, it is the box of the corners.
    """
    extent = np.linalg.norm(warp[:2, :2] * size, axis=1)
    return np.concatenate([warp[:2, 2] - (extent - 1.0) / 2.0, extent])
