"""What differs from attempt to attempt: where the object lies and how what carries it moves."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from sim.belt.carriers import BELT_CENTRE_X_M, CENTRE_M, RADIUS_M, Pose
from sim.checks import look_up

SpeedProfile: TypeAlias = Callable[[float], float]
"""Speed [m/s] of the carrying surface at a time [s]: along +y on a belt, counter-clockwise on a
turntable."""

_RADIAL_SHARE = 0.5
"""A turntable has less room beside the path than the belt: its share of the drawn offset."""

_LOOK_ALIKE_GAP_M = 0.39
"""From one middle to the next along the path, a quarter of the turntable: a hand has room."""


@dataclass(frozen=True)
class Motion:
    """A named kind of motion, scaled by the trial's speed."""

    description: str
    draw: Callable[[float, np.random.Generator], SpeedProfile]
    """The profile at a belt speed [m/s]; what it leaves to chance comes from the generator."""
    carrier: str = "belt"
    """What moves: a name of CARRIERS."""


def _ramp(speed_mps: float, rng: np.random.Generator) -> SpeedProfile:
    """The speed goes from one end to the other within 3 s and stays there."""
    change = 0.5 * rng.choice((-1.0, 1.0))
    first_mps, last_mps = speed_mps * (1.0 - change), speed_mps * (1.0 + change)
    return lambda time_s: first_mps + min(max(time_s / 3.0, 0.0), 1.0) * (last_mps - first_mps)


def _sine(speed_mps: float, rng: np.random.Generator) -> SpeedProfile:
    """The speed swings about its mean with a period of 2 s."""
    phase_rad = rng.uniform(0.0, 2.0 * math.pi)
    return lambda time_s: (
        speed_mps * (1.0 + 0.5 * math.sin(2.0 * math.pi * time_s / 2.0 + phase_rad))
    )


def _stop_and_go(speed_mps: float, rng: np.random.Generator) -> SpeedProfile:
    """The belt starts to accelerate every 1.6 s, and to brake 1 s later, both at 1 m/s²."""
    # A fixed phase lets the grasp fall into the stop every time, and then nothing need be tracked.
    phase_s = rng.uniform(0.0, 1.6)

    def profile(time_s: float) -> float:
        into_s = (time_s + phase_s) % (1.0 + 0.6)
        return max(min(speed_mps, into_s, 1.0) - max(into_s - 1.0, 0.0), 0.0)

    return profile


def _turntable(speed_mps: float, rng: np.random.Generator) -> SpeedProfile:
    """The speed is constant, and its sense is drawn."""
    signed_mps = speed_mps * rng.choice((-1.0, 1.0))
    return lambda time_s: signed_mps


MOTIONS: dict[str, Motion] = {
    "constant": Motion("always the same speed", lambda speed_mps, rng: lambda time_s: speed_mps),
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


@dataclass(frozen=True)
class Scenario:
    """One world: the object's start, at which it already moves, and the motion."""

    profile: SpeedProfile
    start: Pose
    look_alikes: tuple[Pose, ...] = ()
    """Starts of what rides along where the condition asks for it, the first ones first."""


@dataclass(frozen=True)
class ScenarioRange:
    """Ranges that scenarios are drawn from, uniformly."""

    start_y_m: tuple[float, float] = (-0.88, -0.82)
    """Where along the belt the object starts; on a turntable it starts at any angle."""
    offset_m: tuple[float, float] = (-0.08, 0.08)
    """Distance from the belt's centreline, positive away from the robot."""
    yaw_from_path_rad: tuple[float, float] = (-0.5 * math.pi, 0.5 * math.pi)
    """Yaw of the long axis relative to the direction of motion."""

    def draw(self, motion: str, speed_mps: float, rng: np.random.Generator) -> Scenario:
        """The scenario of the next draws of `rng`: where the object lies, how it moves, the rest.

        In this order the same stream lays the object alike whatever the motion, and what rides
        along changes nothing of either.
        """
        start_y_m = rng.uniform(*self.start_y_m)
        beside = self._draw_beside(rng)
        profile = draw_profile(motion, speed_mps, rng)
        angle_rad = rng.uniform(0.0, 2.0 * math.pi)
        is_belt = MOTIONS[motion].carrier == "belt"

        def place(along_m: float, offset_m: float, turn_rad: float) -> Pose:
            if is_belt:
                x_m, y_m = BELT_CENTRE_X_M + offset_m, start_y_m + along_m
                return Pose(x_m, y_m, 0.5 * math.pi + turn_rad)
            angle, radius_m = angle_rad + along_m / RADIUS_M, RADIUS_M + _RADIAL_SHARE * offset_m
            x_m = CENTRE_M[0] + radius_m * math.cos(angle)
            y_m = CENTRE_M[1] + radius_m * math.sin(angle)
            return Pose(x_m, y_m, angle + 0.5 * math.pi + turn_rad)

        side = rng.choice((-1.0, 1.0))
        slots = side * _LOOK_ALIKE_GAP_M * np.array([1.0, -1.0, 2.0])
        look_alikes = tuple(place(float(slot), *self._draw_beside(rng)) for slot in slots)
        return Scenario(profile, place(0.0, *beside), look_alikes)

    def _draw_beside(self, rng: np.random.Generator) -> tuple[float, float]:
        """Offset from the path [m] and yaw from its direction [rad]."""
        return rng.uniform(*self.offset_m), rng.uniform(*self.yaw_from_path_rad)
