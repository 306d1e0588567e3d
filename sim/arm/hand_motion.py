"""How the hand moves over the belt: its pose, the run-up to a moving target, heights by ramps."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


def top_down_pose(position_m: np.ndarray, closing_yaw_rad: float) -> np.ndarray:
    """(4, 4) pose of a hand that points down and closes along `closing_yaw_rad`."""
    c, s = math.cos(closing_yaw_rad), math.sin(closing_yaw_rad)
    T = np.eye(4)
    T[:3, 0] = c, s, 0.0
    T[:3, 1] = s, -c, 0.0
    T[:3, 2] = 0.0, 0.0, -1.0
    T[:3, 3] = position_m
    return T


def run_up(
    y_m: float, speed_mps: float, wait_y_m: float, acceleration_mps2: float
) -> tuple[float, float]:
    """Returns place [m] and speed [m/s] along the belt of a hand that joins a target at `y_m`.

    The hand starts at rest at `wait_y_m` when the target is `v²/(2a)` before it, accelerates at
    `a`, and meets the target at equal position and speed `v²/(2a)` after it. A target that comes
    the other way, on a turntable, is met where it is.
    """
    if speed_mps <= 0.0:
        return (y_m, speed_mps) if y_m >= wait_y_m else (wait_y_m, 0.0)
    distance = 0.5 * speed_mps**2 / acceleration_mps2
    travelled = y_m - (wait_y_m - distance)
    if travelled <= 0.0:
        return wait_y_m, 0.0
    if travelled >= 2.0 * distance:
        return y_m, speed_mps
    elapsed = travelled / speed_mps
    return wait_y_m + 0.5 * acceleration_mps2 * elapsed**2, acceleration_mps2 * elapsed


@dataclass
class Ramp:
    """A scalar that moves to its goal under a speed and an acceleration limit, and stops there."""

    value: float
    speed: float = 0.0

    def step(self, goal: float, fastest: float, acceleration: float, dt: float) -> None:
        """Moves on by one step of `dt` [s]; it can always brake before the goal."""
        distance = goal - self.value
        brake = math.sqrt(2.0 * acceleration * abs(distance))
        wanted = math.copysign(min(fastest, brake, abs(distance) / dt), distance)
        change = acceleration * dt
        self.speed += min(max(wanted - self.speed, -change), change)
        self.value += self.speed * dt
