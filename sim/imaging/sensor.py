"""The camera as a sensor: it exposes at its rate, adds noise, and drops and delays images."""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TypeAlias

import cv2
import numpy as np

from sim.imaging.camera import Window
from sim.imaging.degradations import Condition

Pixels: TypeAlias = tuple[np.ndarray, np.ndarray]
"""(h, w, 3) uint8 colours and (h, w) float32 depth [m]; a depth of 0 is no return."""

Develop: TypeAlias = Callable[[Window], Pixels]
"""Gives the pixels of what was exposed, in a window: only pixels that somebody looks at cost."""


class SensorNoise:
    """Noise of reading, shot noise, and noise and holes of depth.

    One noise picture a trial, larger than the image, is drawn from `rng`; each image sees it
    through a window at a random place. That costs a tenth of fresh noise for every pixel, and the
    images of a trial still look independent to anything that compares neighbours.
    """

    _MARGIN_PX = 64
    _BLOT_PX = 7
    _ORDER = ("colour", "normal", "uniform", "depth_m", "is_hole")
    """In which the places of the windows are drawn."""

    def __init__(
        self, condition: Condition, rng: np.random.Generator, K: np.ndarray | None = None
    ) -> None:
        """`K` (3, 3) are the intrinsics, which depth by time of flight needs."""
        self._rng, self._K, self._time_of_flight = rng, K, condition.time_of_flight
        self._shape = condition.height_px, condition.width_px
        size = (self._shape[0] + self._MARGIN_PX, self._shape[1] + self._MARGIN_PX)
        self._pictures: dict[str, np.ndarray] = {}
        self._std_of_level: np.ndarray | None = None
        has_shot_noise = np.isfinite(condition.full_well_e)
        if has_shot_noise or condition.colour_noise_std > 0.0:
            noise = rng.standard_normal((*size, 3), np.float32)
            if has_shot_noise:
                self._std_of_level = noise_std_of_level(condition)
            else:
                noise = np.rint(noise * condition.colour_noise_std).astype(np.int16)
            self._pictures["colour"] = noise
        if condition.depth_noise_std_m > 0.0:
            noise = rng.standard_normal(size, np.float32)
            self._pictures["depth_m"] = noise * condition.depth_noise_std_m
        if condition.depth_hole_share > 0.0:
            blots = cv2.GaussianBlur(rng.random(size, np.float32), (0, 0), self._BLOT_PX / 2)
            self._pictures["is_hole"] = blots < np.quantile(blots, condition.depth_hole_share)
        if self._time_of_flight is not None:
            if K is None:
                raise ValueError("K must be given where depth is measured by time of flight")
            self._pictures["normal"] = rng.standard_normal(size, np.float32)
            self._pictures["uniform"] = rng.random(size, np.float32)

    def draw(self) -> Callable[[Develop, Window], Pixels]:
        """Draws the noise of the next image; returns what gives the noisy pixels of a window."""
        height, width = self._shape
        parts: dict[str, np.ndarray] = {}
        for name in self._ORDER:
            if name in self._pictures:
                row, column = self._rng.integers(0, self._MARGIN_PX, 2)
                part = self._pictures[name][row : row + height, column : column + width]
                parts[name] = part
        return partial(self._disturbed, parts)

    def _disturbed(self, parts: dict[str, np.ndarray], develop: Develop, window: Window) -> Pixels:
        """The noisy pixels of a window; colours saturate."""
        rgb, depth_m = self._measured(parts, develop, window)
        if "colour" in parts:
            noise = parts["colour"][window]
            if self._std_of_level is not None:
                noise = noise * self._std_of_level[rgb]
            rgb = cv2.add(rgb, noise, dtype=cv2.CV_8U)
        if "depth_m" in parts:
            depth_m = depth_m + parts["depth_m"][window]
        if "is_hole" in parts:
            depth_m = np.where(parts["is_hole"][window], np.float32(0.0), depth_m)
        return rgb, depth_m

    def _measured(self, parts: dict[str, np.ndarray], develop: Develop, window: Window) -> Pixels:
        """True colours; depth by time of flight mixes each pixel with its neighbours."""
        if self._time_of_flight is None or self._K is None:
            return develop(window)
        ends = zip(window, self._shape, strict=True)
        rows, columns = (slice(max(w.start - 1, 0), min(w.stop + 1, n)) for w, n in ends)
        rgb, depth_m = develop((rows, columns))
        K = self._K.copy()
        K[:2, 2] -= columns.start, rows.start
        normal, uniform = (parts[name][rows, columns] for name in ("normal", "uniform"))
        measured_m = self._time_of_flight.measure(depth_m, K, normal, uniform)
        first, height = window[0].start - rows.start, window[0].stop - window[0].start
        left, width = window[1].start - columns.start, window[1].stop - window[1].start
        inner = slice(first, first + height), slice(left, left + width)
        return rgb[inner], measured_m[inner]


def noise_std_of_level(condition: Condition) -> np.ndarray:
    """(256,) float32 standard deviation at each grey level: reading and shot noise together.

    Source: [EMVA1288]: photon noise is Poisson, the variance of the electrons their number. At
    `full_well_e` electrons for level 255 a level g has a variance of 255 g / full_well_e levels².
    """
    level = np.arange(256, dtype=np.float64)
    shot_variance = 255.0 * level / condition.full_well_e
    return np.sqrt(condition.colour_noise_std**2 + shot_variance).astype(np.float32)


@dataclass(frozen=True, eq=False)
class CameraImage:
    """An image that has arrived."""

    crop: Develop
    """Returns the pixels of a window; the same window gives the same pixels."""
    shape_px: tuple[int, int]
    """Rows and columns."""
    time_s: float
    """Middle of the exposure."""
    count: int
    """Images exposed up to this one; 0 for the black one before the first."""

    @cached_property
    def whole(self) -> Pixels:
        """The whole image."""
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
        K: np.ndarray | None = None,
    ) -> None:
        """Prepares the noise.

        Args:
            condition: Resolution, exposure, noise and losses.
            rate_hz: Exposures per second; must divide `tick_hz`.
            delay_s: From the middle of an exposure until the image has arrived.
            tick_hz: Rate of the physics; exposures begin on its steps.
            rng: The only source of randomness.
            K: (3, 3) intrinsics; only time of flight asks for them.
        """
        self._condition = condition
        self._tick_hz = tick_hz
        self._interval = round(tick_hz / rate_hz)
        self._shots = min(max(round(condition.exposure_s * tick_hz), 1), self._interval)
        self._delay = round(delay_s * tick_hz)
        (self._delivery_rng,) = rng.spawn(1)
        self._noise = SensorNoise(condition, rng, K)
        self._open: list[Develop] = []
        self._under_way: deque[tuple[int, CameraImage]] = deque()
        self._count, self._seen_tick, self._is_dropped = 0, -1, False
        shape = condition.height_px, condition.width_px
        black = np.zeros((*shape, 3), np.uint8), np.zeros(shape, np.float32)
        self._newest = CameraImage(lambda part: (black[0][part], black[1][part]), shape, 0.0, 0)

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

    def newest(self, time_s: float) -> CameraImage:
        """Returns the image that has arrived last; a black one before the first."""
        tick = round(time_s * self._tick_hz)
        while self._under_way and self._under_way[0][0] <= tick:
            self._newest = self._under_way.popleft()[1]
        return self._newest

    def _send(self, tick: int) -> None:
        """Closes the shutter and puts the image on its way; none overtakes the one before it."""
        middle = tick - (self._shots - 1) / 2
        mean, noisy = partial(_mean_of, tuple(self._open)), self._noise.draw()
        late = self._happens(self._condition.late_share) * self._condition.late_s
        arrival = max(tick, round(middle + self._delay + late * self._tick_hz))
        if self._under_way:
            arrival = max(arrival, self._under_way[-1][0])
        time_s, shape = middle / self._tick_hz, self._newest.shape_px
        image = CameraImage(partial(noisy, mean), shape, time_s, self._count)
        self._under_way.append((arrival, image))

    def _happens(self, probability: float) -> bool:
        return probability > 0.0 and float(self._delivery_rng.random()) < probability


def _mean_of(shots: Sequence[Develop], window: Window) -> Pixels:
    """Returns mean colours, and the depth of the middle of the exposure."""
    images = [develop(window) for develop in shots]
    if len(images) == 1:
        return images[0]
    colours = np.mean([rgb for rgb, _ in images], axis=0, dtype=np.float32)
    return np.rint(colours).astype(np.uint8), images[len(images) // 2][1]
