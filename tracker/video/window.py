"""The part of an image around the target, at a fixed number of pixels to the template unit.

What follows then costs the same for every image size and every distance of the target.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from tracker.affine.likelihood import Observation

_MIN_SIDE_PX = 8


@dataclass(frozen=True, eq=False)
class Window:
    """A grey cut-out and where it lies."""

    grey: np.ndarray
    """(h, w) float32."""
    to_window: np.ndarray
    """(3, 3) warp from pixels of the image to pixels of the window."""


@dataclass(frozen=True, eq=False)
class WindowObservation:
    """A window under one blur or several falling ones, asked about warps into the whole image.

    Far from the target the coarse pictures lead to it.
    """

    window: Window
    levels: tuple[Observation, ...]
    """The observations of the window from coarse to fine."""

    def log_likelihood(self, warps: np.ndarray) -> np.ndarray:
        """See `Observation`; the finest level decides."""
        return self.levels[-1].log_likelihood(self.window.to_window @ warps)

    def linearise(self, warps: np.ndarray, iteration: int = 0) -> tuple[np.ndarray, np.ndarray]:
        """See `Observation`; each iteration takes the next level, and stays at the finest one.

        Perturbations live in template coordinates, so the window changes nothing.
        """
        level = self.levels[min(iteration, len(self.levels) - 1)]
        return level.linearise(self.window.to_window @ warps, iteration)


def cut_window(
    image: np.ndarray, centre_px: np.ndarray, unit_px: float, reach: float, resolution: float
) -> Window:
    """The window of a BGR image (h, w, 3) around `centre_px` (2,), cut off at its borders.

    Args:
        image: the whole image, uint8.
        centre_px: x and y of the middle of the window.
        unit_px: length of the template unit in the image.
        reach: half a side of the window in template units.
        resolution: pixels of the window to a template unit.
    """
    height, width = image.shape[:2]
    x0, x1 = _interval(centre_px[0], reach * unit_px, width)
    y0, y1 = _interval(centre_px[1], reach * unit_px, height)
    grey = cv2.cvtColor(image[y0:y1, x0:x1], cv2.COLOR_BGR2GRAY)
    zoom = resolution / unit_px
    columns, rows = (max(_MIN_SIDE_PX, round(side * zoom)) for side in (x1 - x0, y1 - y0))
    interpolation = cv2.INTER_AREA if zoom < 1 else cv2.INTER_LINEAR
    small = cv2.resize(grey, (columns, rows), interpolation=interpolation).astype(np.float32)
    sx, sy = columns / (x1 - x0), rows / (y1 - y0)
    return Window(
        small,
        np.array([[sx, 0, (0.5 - x0) * sx - 0.5], [0, sy, (0.5 - y0) * sy - 0.5], [0, 0, 1.0]]),
    )


def _interval(centre: float, reach: float, size: int) -> tuple[int, int]:
    """First pixel and the one past the last, inside the image and not too short."""
    shortest = min(_MIN_SIDE_PX, size)
    first = int(np.clip(centre - reach, 0, size - shortest))
    return first, int(np.clip(centre + reach + 1, first + shortest, size))
