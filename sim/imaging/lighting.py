"""Programmes of the cell's light: its brightness by time and by where the target is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from sim.checks import require_within

BRIGHTEST = 2.0


class Light(Protocol):
    """Brightness of every lamp, 1 being the normal one."""

    def __call__(self, time_s: float, target_y_m: float) -> float:
        """Returns the brightness while the target is at `target_y_m` along the belt."""
        ...


@dataclass(frozen=True)
class SteadyLight:
    """Light that does not change."""

    scale: float = 1.0

    def __post_init__(self) -> None:
        require_within(self, 0.0, BRIGHTEST, "scale")

    def __call__(self, time_s: float, target_y_m: float) -> float:
        """Returns the same brightness at any time."""
        return self.scale


@dataclass(frozen=True)
class SwitchedLight:
    """Light that is switched while the target is under way."""

    before: float
    after: float
    at_y_m: float = -0.72
    """Where the target is then: all of it has come into view, and the hand is on its way to it."""

    def __post_init__(self) -> None:
        require_within(self, 0.0, BRIGHTEST, "before", "after")

    def __call__(self, time_s: float, target_y_m: float) -> float:
        """Returns the brightness before or after the switch."""
        return self.before if target_y_m < self.at_y_m else self.after


@dataclass(frozen=True)
class FlickeringLight:
    """Lamps on the mains: twice its frequency, which a camera at 30 Hz sees as a slow beat."""

    depth: float
    """Amplitude as a share of the mean."""
    rate_hz: float = 100.0

    def __post_init__(self) -> None:
        require_within(self, 0.0, 1.0, "depth")

    def __call__(self, time_s: float, target_y_m: float) -> float:
        """Returns the brightness at that moment."""
        return 1.0 + self.depth * math.sin(2.0 * math.pi * self.rate_hz * time_s)
