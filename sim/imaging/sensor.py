"""The camera as a sensor: it exposes at its rate, adds noise, and drops and delays images."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from sim.imaging.camera import Window
from sim.imaging.degradations import Condition
from sim.imaging.noise import Develop, Image, SensorNoise


@dataclass(frozen=True, eq=False)
class Frame:
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
    def whole(self) -> Image:
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
        """Returns the image that has arrived last."""
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
            crop=lambda window: noise.on(lambda part: _mean_of(shots, part), window),
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
    """Returns the black image that stands in before the first."""
    black = np.zeros((*shape_px, 3), np.uint8), np.zeros(shape_px, np.float32)
    return lambda window: (black[0][window], black[1][window])


def _mean_of(shots: Sequence[Develop], window: Window) -> Image:
    """Returns mean colours, and the depth of the middle of the exposure."""
    images = [develop(window) for develop in shots]
    if len(images) == 1:
        return images[0]
    colours = np.mean([rgb for rgb, _ in images], axis=0, dtype=np.float32)
    return np.rint(colours).astype(np.uint8), images[len(images) // 2][1]
