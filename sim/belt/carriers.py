"""What carries the object past the arm: a still geom whose surface moves, belt or turntable."""

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import cos, sin
from typing import Any, ClassVar

import numpy as np
from dm_control import composer, mjcf

from sim import ASSETS, textures
from sim.geometry import yaw_quaternion

BELT_CENTRE_X_M = 0.50
"""World x of the centreline; the belt runs along +y and carries at z = 0."""

BELT_WIDTH_M = 0.40

CENTRE_M = (BELT_CENTRE_X_M, 0.0)
"""World x and y of the turntable's axis; it carries at z = 0, as the belt does."""

RADIUS_M = 0.25
"""Distance from the axis at which the surface has the stated speed."""

DISC_RADIUS_M = 0.37


@dataclass(frozen=True)
class Pose:
    """A place on a carrying surface, in the world; the belt runs along y."""

    x_m: float
    y_m: float
    yaw_rad: float
    """Direction of the long axis, from the world's x axis."""


class Carrier(composer.ModelWrapperEntity):
    """Stands in front of the robot; its frame is the centre of the carrying surface."""

    face_range_m: ClassVar[tuple[tuple[float, float], tuple[float, float]]]
    """Least and largest world x, then y, between which the face of an object can be."""
    _XML: ClassVar[str]
    _SOLID: ClassVar[tuple[str, ...]]
    """Names of the geoms that the hand must not touch, the carrying one first."""
    _BUSY: ClassVar[tuple[str, ...]]
    """Names of the geoms that show the busy print."""
    _PICTURES: ClassVar[dict[str, Callable[[], np.ndarray]]] = {"busy": textures.busy_print}
    _SURFACE: ClassVar[tuple[int, float]]
    """Component of MuJoCo's surface velocity, and the speed [m/s] where that is 1."""

    def _build(self) -> None:
        self._mjcf_model = mjcf.from_path(str(ASSETS / self._XML))
        self.solid_geoms = self._geoms(self._SOLID)
        """All that the hand must not touch, the carrying geom first."""
        self._busy_geoms = self._geoms(self._BUSY)
        for material, paint in self._PICTURES.items():
            textures.apply(self._mjcf_model, material, paint())
        self._moved, self._shown_at_s = 0.0, 0.0

    def _geoms(self, names: tuple[str, ...]) -> tuple[Any, ...]:
        return tuple(self._mjcf_model.find("geom", name) for name in names)

    @abstractmethod
    def carried(self, pose: Pose, way_m: float) -> Pose:
        """Returns the later pose of what rides at `pose`, the surface moved on by `way_m`."""

    @abstractmethod
    def velocity_at(self, pose: Pose, speed_mps: float) -> tuple[float, float, float]:
        """Returns world x, y velocity [m/s] and yaw rate [rad/s] of what rides there."""

    @abstractmethod
    def _show(self, physics: Any, moved: float) -> None:
        """Shows the surface moved on from its mark, by metres or radians."""

    def speed_mps(self, physics: Any) -> float:
        """Speed of the surface: along +y on a belt, counter-clockwise on a turntable."""
        component, unit_mps = self._SURFACE
        carrying = physics.bind(self.solid_geoms[0]).element_id
        return float(physics.model.geom_surfacevel[carrying, component]) * unit_mps

    def set_speed(self, physics: Any, speed_mps: float) -> None:
        """Sets the surface's speed from the next physics step on."""
        component, unit_mps = self._SURFACE
        carrying = physics.bind(self.solid_geoms[0]).element_id
        physics.model.geom_surfacevel[carrying, component] = speed_mps / unit_mps

    def set_clutter(self, physics: Any, opacity: float) -> None:
        """Shows a busy print on what is seen of it, 0 for none and 1 for all of it."""
        for geom in self._busy_geoms:
            physics.model.geom_rgba[physics.bind(geom).element_id, 3] = opacity

    def show_mark(self, physics: Any) -> None:
        """Puts what is drawn of the surface to its start."""
        self._moved, self._shown_at_s = 0.0, float(physics.time())
        self._show(physics, self._moved)

    def initialize_episode(self, physics: Any, random_state: np.random.RandomState) -> None:
        """Composer's hook: what is drawn of the surface starts at its mark."""
        self.show_mark(physics)

    def after_step(self, physics: Any, random_state: np.random.RandomState) -> None:
        """Composer's hook: what is drawn of the surface moves as far as the surface has."""
        rate = self.speed_mps(physics) / self._SURFACE[1]
        self._moved += rate * (physics.time() - self._shown_at_s)
        self._shown_at_s = float(physics.time())
        self._show(physics, self._moved)


class Conveyor(Carrier):
    """Belt between passive rails; the frame's y runs along the belt."""

    _HALF_M = 0.5 * BELT_WIDTH_M + 0.02
    face_range_m = (BELT_CENTRE_X_M - _HALF_M, BELT_CENTRE_X_M + _HALF_M), (-0.85, 0.85)
    _XML = "conveyor.xml"
    _SOLID = "belt", "rail_near", "rail_far"
    _BUSY = "busy_band", "busy_rail_near", "busy_rail_far"
    _PICTURES = {"rubber": textures.belt_surface, "busy": textures.busy_print}  # noqa: RUF012
    _SURFACE = 1, 1.0
    _PERIODS_M = (("band", 0.1), ("busy_band", 0.4))
    """Geoms whose pictures move, with the periods of their patterns."""

    def carried(self, pose: Pose, way_m: float) -> Pose:
        """Returns the later pose of what rides at `pose`, the surface moved on by `way_m`."""
        return replace(pose, y_m=pose.y_m + way_m)

    def velocity_at(self, pose: Pose, speed_mps: float) -> tuple[float, float, float]:
        """Returns world x, y velocity [m/s] and yaw rate [rad/s] of what rides there."""
        return 0.0, speed_mps, 0.0

    def _show(self, physics: Any, moved: float) -> None:
        """Shifts the pictures of the belt within their patterns' periods; no effect on physics."""
        for name, period_m in self._PERIODS_M:
            offset_m = (moved + 0.5 * period_m) % period_m - 0.5 * period_m
            band = physics.bind(self._mjcf_model.find("geom", name)).element_id
            # Written past the binding, which would have the whole scene computed anew.
            physics.model.geom_sameframe[band] = 0
            physics.data.geom_xpos[band, 1] += offset_m - physics.model.geom_pos[band, 1]
            physics.model.geom_pos[band, 1] = offset_m


class Turntable(Carrier):
    """Plate whose surface turns, in place of the belt; speeds are those at the radius."""

    _REACH_M = DISC_RADIUS_M + 0.03
    face_range_m = (
        (CENTRE_M[0] - _REACH_M, CENTRE_M[0] + _REACH_M),
        (CENTRE_M[1] - _REACH_M, CENTRE_M[1] + _REACH_M),
    )
    _XML, _SOLID, _BUSY = "turntable.xml", ("plate",), ("busy_disc",)
    _SURFACE = 5, RADIUS_M

    def carried(self, pose: Pose, way_m: float) -> Pose:
        """Returns the later pose of what rides at `pose`, with `way_m` gone at the radius."""
        turn = way_m / RADIUS_M
        x, y = pose.x_m - CENTRE_M[0], pose.y_m - CENTRE_M[1]
        c, s = cos(turn), sin(turn)
        return Pose(CENTRE_M[0] + c * x - s * y, CENTRE_M[1] + s * x + c * y, pose.yaw_rad + turn)

    def velocity_at(self, pose: Pose, speed_mps: float) -> tuple[float, float, float]:
        """Returns world x, y velocity [m/s] and yaw rate [rad/s] of what rides there."""
        rate = speed_mps / RADIUS_M
        return -rate * (pose.y_m - CENTRE_M[1]), rate * (pose.x_m - CENTRE_M[0]), rate

    def _show(self, physics: Any, moved: float) -> None:
        """Turns the picture of the disc, from the next physics step on."""
        disc = physics.bind(self._mjcf_model.find("body", "disc")).element_id
        # Written past the binding, which would have the whole scene computed anew.
        physics.model.body_quat[disc] = yaw_quaternion(moved)


CARRIERS: dict[str, Callable[[], Carrier]] = {"belt": Conveyor, "turntable": Turntable}
"""Every carrier that a motion can name."""
