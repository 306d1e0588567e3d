"""What the arm is told of the target: where it is predicted to be, and how it moves."""

from __future__ import annotations

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
        """(3,) in the world."""
        ...

    @property
    def yaw_rate_radps(self) -> float:
        """About world z."""
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
        """The same motion, `dt_s` later."""
        return replace(self, position_m=self.position_m + dt_s * self.velocity_mps)
