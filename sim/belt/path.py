"""Where something lies on a carrying surface."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Pose:
    """A place on the surface, in the world; the belt runs along y."""

    x_m: float
    y_m: float
    yaw_rad: float
    """Direction of the long axis, from the world's x axis."""
