"""What differs from attempt to attempt: where the object lies and how what carries it moves."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sim.conveyor import BELT_CENTRE_X_M
from sim.motions import MOTIONS, SpeedProfile, draw_profile
from sim.turntable import CENTRE_M, RADIUS_M

_RADIAL_SHARE = 0.5
"""A turntable has less room beside the path than the belt: its share of the drawn offset."""


@dataclass(frozen=True)
class Scenario:
    """One world: the object's start, at which it already moves, and the motion."""

    profile: SpeedProfile
    x_m: float
    y_m: float
    """Where the object's centre starts in the world; the belt runs along y."""
    yaw_rad: float
    """Direction of the object's long axis, from the world's x axis."""


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
        """The scenario of the next draws of `rng`: where the object lies, then how it moves.

        In this order the same stream lays the object alike whatever the motion.
        """
        start_y_m = rng.uniform(*self.start_y_m)
        offset_m = rng.uniform(*self.offset_m)
        turn_rad = rng.uniform(*self.yaw_from_path_rad)
        profile = draw_profile(motion, speed_mps, rng)
        if MOTIONS[motion].carrier == "belt":
            x_m = BELT_CENTRE_X_M + offset_m
            return Scenario(profile, x_m, start_y_m, 0.5 * math.pi + turn_rad)
        angle_rad = rng.uniform(0.0, 2.0 * math.pi)
        radius_m = RADIUS_M + _RADIAL_SHARE * offset_m
        x_m = CENTRE_M[0] + radius_m * math.cos(angle_rad)
        y_m = CENTRE_M[1] + radius_m * math.sin(angle_rad)
        return Scenario(profile, x_m, y_m, angle_rad + 0.5 * math.pi + turn_rad)
