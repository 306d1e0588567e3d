"""What differs from attempt to attempt: where the object lies and how what carries it moves."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sim.belt.conveyor import BELT_CENTRE_X_M
from sim.belt.motions import MOTIONS, SpeedProfile, draw_profile
from sim.belt.path import Pose
from sim.belt.turntable import CENTRE_M, RADIUS_M

_RADIAL_SHARE = 0.5
"""A turntable has less room beside the path than the belt: its share of the drawn offset."""

_LOOK_ALIKE_GAP_M = 0.39
"""From one middle to the next along the path, a quarter of the turntable: a hand has room."""


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
                return on_belt(start_y_m + along_m, offset_m, turn_rad)
            return on_turntable(angle_rad + along_m / RADIUS_M, offset_m, turn_rad)

        side = rng.choice((-1.0, 1.0))
        slots = side * _LOOK_ALIKE_GAP_M * np.array([1.0, -1.0, 2.0])
        look_alikes = tuple(place(float(slot), *self._draw_beside(rng)) for slot in slots)
        return Scenario(profile, place(0.0, *beside), look_alikes)

    def _draw_beside(self, rng: np.random.Generator) -> tuple[float, float]:
        """Offset from the path [m] and yaw from its direction [rad]."""
        return rng.uniform(*self.offset_m), rng.uniform(*self.yaw_from_path_rad)


def on_belt(y_m: float, offset_m: float, turn_rad: float) -> Pose:
    """A pose by its place along the belt, beside its middle and turned from its direction."""
    return Pose(BELT_CENTRE_X_M + offset_m, y_m, 0.5 * math.pi + turn_rad)


def on_turntable(angle_rad: float, offset_m: float, turn_rad: float) -> Pose:
    """The same for a turntable, by the angle about its axis, with half the offset."""
    radius_m = RADIUS_M + _RADIAL_SHARE * offset_m
    x_m = CENTRE_M[0] + radius_m * math.cos(angle_rad)
    y_m = CENTRE_M[1] + radius_m * math.sin(angle_rad)
    return Pose(x_m, y_m, angle_rad + 0.5 * math.pi + turn_rad)
