"""A vehicle on two wheels with its camera fixed: it cannot move aside, so it weaves.

The seed's own robot was one [Wu2022, section 6.1.2]; it takes the conversion from a control law of
formation driving that the text does not give. Here the heading leans from the target towards the
wanted motion as far as the camera still sees the target, and the wheels drive the part of the
motion that lies along the heading, backwards if need be.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracker.bearing_only.measurements import BodyIncrement
from tracker.checks import require_positive


@dataclass(frozen=True)
class DifferentialDrive:
    """What the wheels allow."""

    max_turn_rate_radps: float = 1.0
    lean_rad: float = 0.35
    """How far the heading may lean from the target; within half the camera's field of view."""

    def __post_init__(self) -> None:
        require_positive(self, "max_turn_rate_radps", "lean_rad")

    def convert(
        self, wanted_mps: NDArray[np.float64], ray_b: NDArray[np.float64], dt_s: float
    ) -> BodyIncrement:
        """The increment nearest to a free motion: forward or backward, and a turn in the plane.

        Args:
            wanted_mps: (..., 3) velocity in the body's frame; its vertical part is left out.
            ray_b: (..., 3) direction of the target in the body's frame.
            dt_s: Time step.
        """
        x, y = wanted_mps[..., 0], wanted_mps[..., 1]
        sense = np.where(x < 0.0, -1.0, 1.0)
        course = np.arctan2(sense * y, sense * x)
        bearing = np.arctan2(ray_b[..., 1], ray_b[..., 0])
        heading = np.clip(course, bearing - self.lean_rad, bearing + self.lean_rad)
        most = self.max_turn_rate_radps * dt_s
        turn = np.clip(heading, -most, most)
        speed = sense * np.hypot(x, y) * np.maximum(np.cos(course - turn), 0.0)
        zero = np.zeros_like(speed)
        return BodyIncrement(
            np.stack([dt_s * speed, zero, zero], axis=-1), np.stack([zero, zero, turn], axis=-1)
        )
