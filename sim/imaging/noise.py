"""What a sensor adds to an image: noise of reading, shot noise, and the errors of its depth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import cv2
import numpy as np

from sim.imaging.camera import Window
from sim.imaging.degradations import Condition
from sim.imaging.time_of_flight import TimeOfFlight

Image: TypeAlias = tuple[np.ndarray, np.ndarray]
"""(h, w, 3) uint8 colours and (h, w) float32 depth [m]."""

Develop: TypeAlias = Callable[[Window], Image]
"""Gives the pixels of what was exposed, in a window: only pixels that somebody looks at cost."""


class SensorNoise:
    """Noise of reading, shot noise, and noise and holes of depth.

    One noise picture a trial, larger than the image, is drawn from `rng`; each frame sees it
    through a window at a random place. That costs a tenth of fresh noise for every pixel, and the
    frames of a trial still look independent to anything that compares neighbours.
    """

    _MARGIN_PX = 64
    _BLOT_PX = 7

    def __init__(
        self, condition: Condition, rng: np.random.Generator, K: np.ndarray | None = None
    ) -> None:
        """`K` (3, 3) are the intrinsics, which depth by time of flight needs."""
        self._rng, self._K = rng, K
        self._height, self._width = condition.height_px, condition.width_px
        size = (self._height + self._MARGIN_PX, self._width + self._MARGIN_PX)
        self._colour = self._depth = self._holes = self._std_of_level = None
        has_shot_noise = np.isfinite(condition.full_well_e)
        if has_shot_noise or condition.colour_noise_std > 0.0:
            noise = rng.standard_normal((*size, 3), np.float32)
            if has_shot_noise:
                self._std_of_level = noise_std_of_level(condition)
                self._colour = noise
            else:
                self._colour = np.rint(noise * condition.colour_noise_std).astype(np.int16)
        if condition.depth_noise_std_m > 0.0:
            self._depth = rng.standard_normal(size, np.float32) * condition.depth_noise_std_m
        if condition.depth_hole_share > 0.0:
            blots = cv2.GaussianBlur(rng.random(size, np.float32), (0, 0), self._BLOT_PX / 2)
            self._holes = blots < np.quantile(blots, condition.depth_hole_share)
        self._time_of_flight = condition.time_of_flight
        if self._time_of_flight is not None:
            if K is None:
                raise ValueError("K must be given where depth is measured by time of flight")
            self._normal = rng.standard_normal(size, np.float32)
            self._uniform = rng.random(size, np.float32)

    def draw(self) -> FrameNoise:
        """Returns the noise of the next image."""
        return FrameNoise(
            colour=self._part(self._colour),
            std_of_level=self._std_of_level,
            depth_camera=self._depth_camera(),
            depth_m=self._part(self._depth),
            is_hole=self._part(self._holes),
        )

    def _depth_camera(self) -> DepthCamera | None:
        if self._time_of_flight is None:
            return None
        normal, uniform = self._part(self._normal), self._part(self._uniform)
        assert self._K is not None and normal is not None and uniform is not None
        return DepthCamera(self._time_of_flight, self._K, normal, uniform)

    def _part(self, picture: np.ndarray | None) -> np.ndarray | None:
        """Returns a part of a noise picture, as large as the image."""
        if picture is None:
            return None
        row, column = self._rng.integers(0, self._MARGIN_PX, 2)
        return picture[row : row + self._height, column : column + self._width]


@dataclass(frozen=True, eq=False)
class DepthCamera:
    """Depth by time of flight, with the draws of one image."""

    errors: TimeOfFlight
    K: np.ndarray
    """(3, 3) intrinsics of the whole image."""
    normal: np.ndarray
    """(h, w) draws from the standard normal distribution."""
    uniform: np.ndarray
    """(h, w) draws from 0 to 1."""

    def measure(self, develop: Develop, window: Window) -> Image:
        """True colours and measured depth in a window; each pixel mixes with its neighbours."""
        ends = zip(window, self.normal.shape, strict=True)
        wide = tuple(slice(max(w.start - 1, 0), min(w.stop + 1, n)) for w, n in ends)
        rgb, depth_m = develop((wide[0], wide[1]))
        K = self.K.copy()
        K[:2, 2] -= wide[1].start, wide[0].start
        measured_m = self.errors.measure(depth_m, K, self.normal[wide], self.uniform[wide])
        rows, columns = (
            slice(w.start - v.start, w.stop - v.start) for w, v in zip(window, wide, strict=True)
        )
        return rgb[rows, columns], measured_m[rows, columns]


@dataclass(frozen=True, eq=False)
class FrameNoise:
    """The noise of one image; None where a kind of noise is absent."""

    colour: np.ndarray | None
    """(h, w, 3): grey levels, or deviations in units of `std_of_level`."""
    std_of_level: np.ndarray | None
    """(256,) standard deviation by grey level; None for noise alike at every level."""
    depth_camera: DepthCamera | None
    depth_m: np.ndarray | None
    """(h, w) errors of the depth."""
    is_hole: np.ndarray | None
    """(h, w) bool, where no depth is measured."""

    def on(self, develop: Develop, window: Window) -> Image:
        """The noisy pixels of a window: (h, w, 3) uint8 colours, saturated, and (h, w) depth [m].

        A depth of 0 is no return.
        """
        if self.depth_camera is None:
            rgb, depth_m = develop(window)
        else:
            rgb, depth_m = self.depth_camera.measure(develop, window)
        if self.colour is not None:
            noise = self.colour[window]
            if self.std_of_level is not None:
                noise = noise * self.std_of_level[rgb]
            rgb = cv2.add(rgb, noise, dtype=cv2.CV_8U)
        if self.depth_m is not None:
            depth_m = depth_m + self.depth_m[window]
        if self.is_hole is not None:
            depth_m = np.where(self.is_hole[window], np.float32(0.0), depth_m)
        return rgb, depth_m


def noise_std_of_level(condition: Condition) -> np.ndarray:
    """(256,) float32 standard deviation at each grey level: reading and shot noise together.

    Source: [EMVA1288]: photon noise is Poisson, the variance of the electrons their number. At
    `full_well_e` electrons for level 255 a level g has a variance of 255 g / full_well_e levels².
    """
    level = np.arange(256, dtype=np.float64)
    shot_variance = 255.0 * level / condition.full_well_e
    return np.sqrt(condition.colour_noise_std**2 + shot_variance).astype(np.float32)
