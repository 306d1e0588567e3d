"""Smooth, band-limited motion: terms that are written down, signals that are drawn from them.

Time is counted in frames from the first one, and is real: an exposure lasts a part of a frame.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

Signal = Callable[[float], float]
"""A value as a function of the time [frames]; 0 at time 0."""

_TONES = 3
_CHECKS_PER_FRAME = 8


class Term(Protocol):
    """A part of a motion, before its random numbers are drawn."""

    def draw(self, frame_count: int, rng: np.random.Generator) -> Signal:
        """The signal for a film of `frame_count` frames."""
        ...


Terms = tuple[Term, ...]
"""The sum of some terms; none is a standstill."""


@dataclass(frozen=True)
class Wave:
    """Three sinusoids of random phase, scaled so that the film contains the peak exactly."""

    peak: float
    """The value farthest from the start, with its sign; the other side goes no farther."""
    periods: tuple[float, float]
    """Shortest and longest period [frames]."""

    def __post_init__(self) -> None:
        _require_periods(self.periods)

    def draw(self, frame_count: int, rng: np.random.Generator) -> Signal:
        """See `Term`."""
        shortest, longest = (float(log) for log in np.log(self.periods))
        edges = np.linspace(shortest, longest, _TONES + 1)
        rates = 2.0 * np.pi / np.exp(rng.uniform(edges[:-1], edges[1:]))
        phases = rng.uniform(0.0, 2.0 * np.pi, _TONES)
        sizes = rng.uniform(0.5, 1.0, _TONES) / rates**0.5

        def tones(times: np.ndarray | float) -> np.ndarray:
            return np.sin(np.multiply.outer(times, rates) + phases) @ sizes

        start = tones(0.0)
        times = np.arange(_CHECKS_PER_FRAME * (frame_count - 1) + 1) / _CHECKS_PER_FRAME
        values = tones(times) - start
        scale = self.peak / values[np.argmax(np.abs(values))]
        return lambda time: float(scale * (tones(time) - start))


@dataclass(frozen=True)
class Swing:
    """A swing to the peak and back, again and again, never beyond either end."""

    peak: float
    """The far end, with its sign."""
    periods: tuple[float, float]
    """Range of the period [frames]."""

    def __post_init__(self) -> None:
        _require_periods(self.periods)

    def draw(self, frame_count: int, rng: np.random.Generator) -> Signal:
        """See `Term`."""
        del frame_count
        rate = 2.0 * np.pi / rng.uniform(*self.periods)
        return lambda time: 0.5 * self.peak * (1.0 - math.cos(rate * time))


@dataclass(frozen=True)
class Trip:
    """A trip away and back after a stay, with smooth starts and stops; nothing in it is random."""

    by: float
    """How far it goes."""
    leave: float
    """When it starts to go [frames]."""
    back: float
    """When it starts to come back [frames]."""
    ramp: float
    """How long each way takes [frames]."""

    def __post_init__(self) -> None:
        if not (0.0 < self.ramp and 0.0 <= self.leave <= self.back):
            raise ValueError(
                f"leave, back, ramp must be 0 <= leave <= back and ramp > 0, got "
                f"{self.leave}, {self.back}, {self.ramp}"
            )

    def draw(self, frame_count: int, rng: np.random.Generator) -> Signal:
        """See `Term`."""
        del frame_count, rng
        ramp = self.ramp
        return lambda time: (
            self.by
            * (_smooth_step((time - self.leave) / ramp) - _smooth_step((time - self.back) / ramp))
        )


def draw_sum(terms: Terms, frame_count: int, rng: np.random.Generator) -> Signal:
    """Returns the sum of the drawn terms."""
    signals = [term.draw(frame_count, rng) for term in terms]
    return lambda time: math.fsum(signal(time) for signal in signals)


def _require_periods(periods: tuple[float, float]) -> None:
    if not 0.0 < periods[0] <= periods[1]:
        raise ValueError(f"periods must be (short, long), both above 0, got {periods}")


def _smooth_step(x: float) -> float:
    """0 up to x = 0, 1 from x = 1, with continuous acceleration between."""
    x = min(max(x, 0.0), 1.0)
    return x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
