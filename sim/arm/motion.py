"""How the target moves as the arm knows it, and how the hand joins it over the belt."""

import math
from dataclasses import dataclass, replace
from typing import Protocol, Self

import numpy as np


class TargetMotion(Protocol):
    """Where the target's top face is predicted to be, and how it moves."""

    @property
    def position_m(self) -> np.ndarray:
        """(3,) centre of the top face in the world."""
        ...

    @property
    def yaw_rad(self) -> float:
        """Direction of the long axis about world z."""
        ...

    @property
    def velocity_mps(self) -> np.ndarray:
        """(3,) velocity in the world."""
        ...

    @property
    def yaw_rate_radps(self) -> float:
        """Rate of turn about world z."""
        ...


@dataclass(frozen=True, eq=False)
class UniformMotion:
    """A target that moves on in a straight line."""

    position_m: np.ndarray
    yaw_rad: float
    velocity_mps: np.ndarray
    yaw_rate_radps: float = 0.0

    @classmethod
    def of(cls, target: TargetMotion) -> Self:
        """The target's motion along the belt of now: neither turning nor rising."""
        velocity = np.array([*target.velocity_mps[:2], 0.0])
        return cls(np.array(target.position_m), target.yaw_rad, velocity)

    def after(self, dt_s: float) -> Self:
        """Returns the same motion, `dt_s` later."""
        return replace(self, position_m=self.position_m + dt_s * self.velocity_mps)


def servo_error(target: TargetMotion, T_world_tcp: np.ndarray, depth_m: float) -> float:
    """Norm of the pose error between the hand and its grasp on the target.

    Source: [IGPF2021] Eq. (26), `e = [p_t + δ n - p_e; e_o]` with n the face normal; the text
    mixes metres and radians, here a radian counts as 0.1 m (half the length of the box).
    """
    grasp_position = np.asarray(target.position_m) - [0.0, 0.0, depth_m]
    closing = math.atan2(T_world_tcp[1, 0], T_world_tcp[0, 0])
    turn = math.remainder(target.yaw_rad + 0.5 * math.pi - closing, math.pi)
    return float(np.linalg.norm([*(grasp_position - T_world_tcp[:3, 3]), 0.1 * turn]))


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
