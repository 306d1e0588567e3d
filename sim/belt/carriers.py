"""What carries the object past the arm, by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from sim.belt.conveyor import Conveyor
from sim.belt.path import Pose
from sim.belt.turntable import Turntable


class Carrier(Protocol):
    """A composer entity with a surface that moves; it stands in front of the robot."""

    @property
    def solid_geoms(self) -> tuple[Any, ...]:
        """All that the hand must not touch."""
        ...

    @property
    def face_range_m(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Least and largest world x, then y, between which the face of an object can be."""
        ...

    def carried(self, pose: Pose, way_m: float) -> Pose:
        """Returns the later pose of what rides at `pose`, the surface moved on by `way_m`."""
        ...

    def velocity_at(self, pose: Pose, speed_mps: float) -> tuple[float, float, float]:
        """Returns world x, y velocity [m/s] and yaw rate [rad/s] of what rides there."""
        ...

    def set_speed(self, physics: Any, speed_mps: float) -> None:
        """Sets the surface's speed from the next physics step on."""
        ...

    def speed_mps(self, physics: Any) -> float:
        """The surface's speed."""
        ...

    def set_clutter(self, physics: Any, opacity: float) -> None:
        """Shows a busy print on what is seen of it, 0 for none and 1 for all of it."""
        ...

    def show_mark(self, physics: Any) -> None:
        """Puts what is drawn of the surface to its start."""
        ...


CARRIERS: dict[str, Callable[[], Carrier]] = {"belt": Conveyor, "turntable": Turntable}
"""Every carrier that a motion can name."""
