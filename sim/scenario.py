"""What differs from attempt to attempt: where the object lies and how the belt runs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sim.motions import SpeedProfile, draw_profile


@dataclass(frozen=True)
class Scenario:
    """One world: the object's start and the belt's motion."""

    profile: SpeedProfile
    start_y_m: float
    """Where along the belt the object's centre starts; it already moves with the belt."""
    offset_m: float
    """Lateral distance from the belt's centreline, positive away from the robot."""
    yaw_rad: float
    """Direction of the object's long axis, from the world's x axis."""


@dataclass(frozen=True)
class ScenarioRange:
    """Ranges that scenarios are drawn from, uniformly."""

    start_y_m: tuple[float, float] = (-0.88, -0.82)
    offset_m: tuple[float, float] = (-0.08, 0.08)
    yaw_from_belt_rad: tuple[float, float] = (-0.5 * math.pi, 0.5 * math.pi)
    """Yaw of the long axis relative to the belt's direction."""

    def draw(self, motion: str, speed_mps: float, rng: np.random.Generator) -> Scenario:
        """The scenario of the next draws of `rng`: where the object lies, then how the belt runs.

        In this order the same stream lays the object alike whatever the motion.
        """
        start_y_m = rng.uniform(*self.start_y_m)
        offset_m = rng.uniform(*self.offset_m)
        yaw_rad = 0.5 * math.pi + rng.uniform(*self.yaw_from_belt_rad)
        return Scenario(draw_profile(motion, speed_mps, rng), start_y_m, offset_m, yaw_rad)
