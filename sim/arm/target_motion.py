"""The target as the arm knows it: where it is predicted to be, how it moves, how far it is off."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Protocol

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
    def of(cls, target: TargetMotion) -> UniformMotion:
        """The target's motion along the belt of now: neither turning nor rising."""
        velocity = np.array([*target.velocity_mps[:2], 0.0])
        return cls(np.array(target.position_m), target.yaw_rad, velocity)

    def after(self, dt_s: float) -> UniformMotion:
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
