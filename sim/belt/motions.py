"""How the belt's speed changes, or the turntable's: named motions, scaled by the trial's speed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from sim.checks import look_up


class SpeedProfile(Protocol):
    """Speed of the carrying surface as a function of time."""

    def __call__(self, time_s: float) -> float:
        """Speed [m/s] at `time_s`: along +y on a belt, counter-clockwise on a turntable."""
        ...


@dataclass(frozen=True)
class ConstantSpeed:
    """A surface that always moves at the same speed."""

    speed_mps: float

    def __call__(self, time_s: float) -> float:
        """Speed [m/s], whatever the time."""
        return self.speed_mps


@dataclass(frozen=True)
class RampSpeed:
    """A belt whose speed goes from `first_mps` to `last_mps` and stays there."""

    first_mps: float
    last_mps: float
    duration_s: float

    def __call__(self, time_s: float) -> float:
        """Speed along +y [m/s] at `time_s`."""
        share = min(max(time_s / self.duration_s, 0.0), 1.0)
        return self.first_mps + share * (self.last_mps - self.first_mps)


@dataclass(frozen=True)
class SineSpeed:
    """A belt whose speed swings about its mean."""

    mean_mps: float
    swing: float
    """Amplitude as a share of the mean."""
    period_s: float
    phase_rad: float

    def __call__(self, time_s: float) -> float:
        """Speed along +y [m/s] at `time_s`."""
        angle = 2.0 * math.pi * time_s / self.period_s + self.phase_rad
        return self.mean_mps * (1.0 + self.swing * math.sin(angle))


@dataclass(frozen=True)
class StopAndGoSpeed:
    """A belt that runs, brakes, stands and starts again."""

    speed_mps: float
    run_s: float
    """From the start of the acceleration to the start of the braking."""
    stand_s: float
    """From the start of the braking to the next start."""
    acceleration_mps2: float
    phase_s: float
    """How far into a period the belt is at time 0."""

    def __call__(self, time_s: float) -> float:
        """Speed along +y [m/s] at `time_s`."""
        into_s = (time_s + self.phase_s) % (self.run_s + self.stand_s)
        reached = min(self.speed_mps, self.acceleration_mps2 * min(into_s, self.run_s))
        return max(reached - self.acceleration_mps2 * max(into_s - self.run_s, 0.0), 0.0)


@dataclass(frozen=True)
class Motion:
    """A named kind of motion."""

    description: str
    draw: Callable[[float, np.random.Generator], SpeedProfile]
    """The profile at a belt speed [m/s]; what it leaves to chance comes from the generator."""
    carrier: str = "belt"
    """What moves: a name of CARRIERS."""


def _ramp(speed_mps: float, rng: np.random.Generator) -> RampSpeed:
    change = 0.5 * rng.choice((-1.0, 1.0))
    return RampSpeed(speed_mps * (1.0 - change), speed_mps * (1.0 + change), duration_s=3.0)


def _sine(speed_mps: float, rng: np.random.Generator) -> SineSpeed:
    return SineSpeed(speed_mps, 0.5, period_s=2.0, phase_rad=rng.uniform(0.0, 2.0 * math.pi))


def _stop_and_go(speed_mps: float, rng: np.random.Generator) -> StopAndGoSpeed:
    # A fixed phase lets the grasp fall into the stop every time, and then nothing need be tracked.
    return StopAndGoSpeed(
        speed_mps, run_s=1.0, stand_s=0.6, acceleration_mps2=1.0, phase_s=rng.uniform(0.0, 1.6)
    )


def _turntable(speed_mps: float, rng: np.random.Generator) -> ConstantSpeed:
    return ConstantSpeed(speed_mps * rng.choice((-1.0, 1.0)))


MOTIONS: dict[str, Motion] = {
    "constant": Motion("always the same speed", lambda speed_mps, rng: ConstantSpeed(speed_mps)),
    "ramp": Motion("from half the speed to one and a half in 3 s, or the other way", _ramp),
    "sine": Motion("speed swings by half about its mean, every 2 s, at any phase", _sine),
    "stop-and-go": Motion(
        "runs for 1.0 s, brakes and stands for 0.6 s, at 1 m/s² and at any phase", _stop_and_go
    ),
    "turntable": Motion(
        "no belt: a circle of radius 0.25 m, either way round, the speed always the same",
        _turntable,
        carrier="turntable",
    ),
}
"""Every motion that a trial can name."""


def draw_profile(name: str, speed_mps: float, rng: np.random.Generator) -> SpeedProfile:
    """A profile of the named motion; ValueError for an unknown name or an impossible speed."""
    motion = look_up("motion", name, MOTIONS)
    if not (math.isfinite(speed_mps) and speed_mps >= 0.0):
        raise ValueError(f"speed_mps must be finite and >= 0, got {speed_mps!r}")
    return motion.draw(speed_mps, rng)
