"""A vehicle on two wheels with its camera fixed: it cannot move aside, so it weaves.

The paper's own robot was one [Wu2022, section 6.1.2]; it takes the conversion from a control law of
formation driving that the text does not give. Here the heading leans from the target towards the
wanted motion as far as the camera still sees the target, and the wheels drive forward or backward
along it at the wanted speed: a saw-tooth that creeps aside, as one parks a car.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracker.bearing_only.measurements import BodyIncrement
from tracker.checks import require_positive, require_share


@dataclass(frozen=True)
class DifferentialDrive:
    """What the wheels allow."""

    max_turn_rate_radps: float = 1.0
    lean_rad: float = 0.35
    """How far the heading may lean from the target; within half the camera's field of view."""

    turn_back_share: float = 0.1
    """The wheels change between forward and backward when the wanted motion along the body's axis
    is this share of the speed the other way; without such a gap they would chatter."""

    def __post_init__(self) -> None:
        require_positive(self, "max_turn_rate_radps", "lean_rad")
        require_share(self, "turn_back_share")


class WheelDrive:
    """Turns free motions into those of the wheels; remembers whether it drives backward."""

    def __init__(self, config: DifferentialDrive) -> None:
        self._config = config
        self._sense: NDArray[np.float64] | None = None

    def convert(
        self, wanted_mps: NDArray[np.float64], ray_b: NDArray[np.float64], dt_s: float
    ) -> BodyIncrement:
        """The increment for a wanted motion: forward or backward, and a turn in the plane.

        Args:
            wanted_mps: (..., 3) velocity in the body's frame; its vertical part is left out.
            ray_b: (..., 3) direction of the target in the body's frame.
            dt_s: Time step.
        """
        x, y = wanted_mps[..., 0], wanted_mps[..., 1]
        speed = np.hypot(x, y)
        sense = self._sense_of(x, speed)
        course = np.arctan2(sense * y, sense * x)
        bearing = np.arctan2(ray_b[..., 1], ray_b[..., 0])
        lean, most = self._config.lean_rad, self._config.max_turn_rate_radps * dt_s
        turn = np.clip(np.clip(course, bearing - lean, bearing + lean), -most, most)
        is_possible = np.cos(course - turn) > 0.0
        forward = np.where(is_possible, sense * speed, 0.0)
        zero = np.zeros_like(forward)
        return BodyIncrement(
            np.stack([dt_s * forward, zero, zero], axis=-1), np.stack([zero, zero, turn], axis=-1)
        )

    def _sense_of(self, x: NDArray[np.float64], speed: NDArray[np.float64]) -> NDArray[np.float64]:
        """(...,): 1 for forward, -1 for backward."""
        if self._sense is None:
            self._sense = np.where(x < 0.0, -1.0, 1.0)
        is_against = self._sense * x < -self._config.turn_back_share * speed
        self._sense = np.where(is_against, -self._sense, self._sense)
        return self._sense
