"""The camera as its user has it: it exposes at its rate, adds noise, drops and delays images."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import cv2
import numpy as np

from sim.camera import Window
from sim.degradations import Condition

Image: TypeAlias = tuple[np.ndarray, np.ndarray]
"""(h, w, 3) uint8 colours and (h, w) float32 depth [m]."""

Develop: TypeAlias = Callable[[Window], Image]
"""Gives the pixels of what was exposed, in a window: only pixels that somebody looks at cost."""


@dataclass(frozen=True, eq=False)
class Frame:
    """An image that has arrived."""

    crop: Develop
    """A part of it; equal parts are equal."""
    shape_px: tuple[int, int]
    """Rows and columns."""
    time_s: float
    """Middle of the exposure."""
    count: int
    """Images exposed up to this one; 0 for the black one before the first."""

    @cached_property
    def whole(self) -> Image:
        """All of it."""
        rows, columns = self.shape_px
        return self.crop((slice(0, rows), slice(0, columns)))


class Sensor:
    """The stream of images of one trial."""

    def __init__(
        self,
        condition: Condition,
        rate_hz: float,
        delay_s: float,
        tick_hz: int,
        rng: np.random.Generator,
    ) -> None:
        """Prepares the noise.

        Args:
            condition: Resolution, exposure, noise and losses.
            rate_hz: Exposures per second; must divide `tick_hz`.
            delay_s: From the middle of an exposure until the image has arrived.
            tick_hz: Rate of the physics; exposures begin on its steps.
            rng: The only source of randomness.
        """
        self._condition = condition
        self._tick_hz = tick_hz
        self._interval = round(tick_hz / rate_hz)
        self._shots = min(max(round(condition.exposure_s * tick_hz), 1), self._interval)
        self._delay = round(delay_s * tick_hz)
        (self._delivery_rng,) = rng.spawn(1)
        self._noise = SensorNoise(condition, rng)
        self._open: list[Develop] = []
        self._under_way: deque[tuple[int, Frame]] = deque()
        self._count, self._seen_tick, self._is_dropped = 0, -1, False
        self._shape_px = condition.height_px, condition.width_px
        self._newest = Frame(_black(self._shape_px), self._shape_px, time_s=0.0, count=0)

    def look(self, time_s: float, expose: Callable[[], Develop]) -> None:
        """Exposes if it is time to; to be called at every physics step, more often does no harm.

        Args:
            time_s: Simulated time.
            expose: Takes the noise-free picture of now; called only while the shutter is open.
        """
        tick = round(time_s * self._tick_hz)
        if tick == self._seen_tick:
            return
        self._seen_tick = tick
        shot = tick % self._interval
        if shot == 0:
            self._count += 1
            self._open = []
            self._is_dropped = self._happens(self._condition.dropped_share)
        if shot >= self._shots or self._is_dropped:
            return
        self._open.append(expose())
        if shot == self._shots - 1:
            self._send(tick)

    def newest(self, time_s: float) -> Frame:
        """The image that has arrived last."""
        tick = round(time_s * self._tick_hz)
        while self._under_way and self._under_way[0][0] <= tick:
            self._newest = self._under_way.popleft()[1]
        return self._newest

    def _send(self, tick: int) -> None:
        """Closes the shutter and puts the image on its way; none overtakes the one before it."""
        middle = tick - (self._shots - 1) / 2
        shots, noise = tuple(self._open), self._noise.draw()
        late = self._happens(self._condition.late_share) * self._condition.late_s
        arrival = max(tick, round(middle + self._delay + late * self._tick_hz))
        frame = Frame(
            crop=lambda window: noise.on(*_mean_of(shots, window), window),
            shape_px=self._shape_px,
            time_s=middle / self._tick_hz,
            count=self._count,
        )
        if self._under_way:
            arrival = max(arrival, self._under_way[-1][0])
        self._under_way.append((arrival, frame))

    def _happens(self, probability: float) -> bool:
        return probability > 0.0 and float(self._delivery_rng.random()) < probability


def _black(shape_px: tuple[int, int]) -> Develop:
    """What there is to see before the first image."""
    black = np.zeros((*shape_px, 3), np.uint8), np.zeros(shape_px, np.float32)
    return lambda window: (black[0][window], black[1][window])


def _mean_of(shots: Sequence[Develop], window: Window) -> Image:
    """Mean colours, and the depth of the middle of the exposure."""
    images = [develop(window) for develop in shots]
    if len(images) == 1:
        return images[0]
    colours = np.mean([rgb for rgb, _ in images], axis=0, dtype=np.float32)
    return np.rint(colours).astype(np.uint8), images[len(images) // 2][1]


class SensorNoise:
    """Noise of reading, shot noise, and noise and holes of depth.

    One noise picture a trial, larger than the image, is drawn from `rng`; each frame sees it
    through a window at a random place. That costs a tenth of fresh noise for every pixel, and the
    frames of a trial still look independent to anything that compares neighbours.
    """

    _MARGIN_PX = 64
    _BLOT_PX = 7

    def __init__(self, condition: Condition, rng: np.random.Generator) -> None:
        self._rng = rng
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

    def draw(self) -> FrameNoise:
        """The noise of the next image."""
        return FrameNoise(
            colour=self._part(self._colour),
            depth_m=self._part(self._depth),
            is_hole=self._part(self._holes),
            std_of_level=self._std_of_level,
        )

    def _part(self, picture: np.ndarray | None) -> np.ndarray | None:
        """A part of a noise picture, as large as the image."""
        if picture is None:
            return None
        row, column = self._rng.integers(0, self._MARGIN_PX, 2)
        return picture[row : row + self._height, column : column + self._width]


@dataclass(frozen=True, eq=False)
class FrameNoise:
    """The noise of one image; None where a kind of noise is absent."""

    colour: np.ndarray | None
    """(h, w, 3): grey levels, or deviations where `std_of_level` tells their size."""
    depth_m: np.ndarray | None
    """(h, w)"""
    is_hole: np.ndarray | None
    """(h, w) bool"""
    std_of_level: np.ndarray | None
    """(256,) of `noise_std_of_level`."""

    def on(self, rgb: np.ndarray, depth_m: np.ndarray, window: Window) -> Image:
        """The noisy pixels of a window: (h, w, 3) uint8 colours, saturated, and (h, w) depth [m].

        A depth of 0 is no return.
        """
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
