"""Turntable: a still plate whose surface turns, in place of the belt."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from dm_control import composer, mjcf

from sim import ASSETS, textures
from sim.belt.conveyor import BELT_CENTRE_X_M
from sim.belt.path import Pose
from sim.geometry import yaw_quaternion

CENTRE_M = (BELT_CENTRE_X_M, 0.0)
"""World x and y of the axis; the table carries at z = 0, as the belt does."""

RADIUS_M = 0.25
"""Distance from the axis at which the surface has the stated speed."""

DISC_RADIUS_M = 0.37


class Turntable(composer.Entity):
    """Turntable; its frame is the centre of the carrying surface."""

    def _build(self) -> None:
        self._mjcf_root = mjcf.from_path(str(ASSETS / "turntable.xml"))
        self.solid_geoms: tuple[Any, ...] = (self._mjcf_root.find("geom", "plate"),)
        """The plate."""
        self._busy = self._mjcf_root.find("geom", "busy_disc")
        textures.apply(self._mjcf_root, "busy", textures.busy_print())
        self._disc = self._mjcf_root.find("body", "disc")
        self._turn_rad, self._shown_at_s = 0.0, 0.0

    @property
    def mjcf_model(self) -> Any:
        """PyMJCF model of the turntable."""
        return self._mjcf_root

    @property
    def face_range_m(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Least and largest world x, then y, between which the face of an object can be."""
        (x, y), reach = CENTRE_M, DISC_RADIUS_M + 0.03
        return (x - reach, x + reach), (y - reach, y + reach)

    def carried(self, pose: Pose, way_m: float) -> Pose:
        """Returns the later pose of what rides at `pose`, with `way_m` gone at the radius."""
        turn = way_m / RADIUS_M
        x, y = pose.x_m - CENTRE_M[0], pose.y_m - CENTRE_M[1]
        c, s = math.cos(turn), math.sin(turn)
        return Pose(CENTRE_M[0] + c * x - s * y, CENTRE_M[1] + s * x + c * y, pose.yaw_rad + turn)

    def velocity_at(self, pose: Pose, speed_mps: float) -> tuple[float, float, float]:
        """Returns world x, y velocity [m/s] and yaw rate [rad/s] of what rides there."""
        rate = speed_mps / RADIUS_M
        return -rate * (pose.y_m - CENTRE_M[1]), rate * (pose.x_m - CENTRE_M[0]), rate

    def speed_mps(self, physics: Any) -> float:
        """Speed of the surface at the radius, counter-clockwise."""
        plate = physics.bind(*self.solid_geoms).element_id
        return float(physics.model.geom_surfacevel[plate, 5]) * RADIUS_M

    def set_clutter(self, physics: Any, opacity: float) -> None:
        """Shows a busy print on the disc, 0 for none and 1 for all of it."""
        physics.model.geom_rgba[physics.bind(self._busy).element_id, 3] = opacity

    def set_speed(self, physics: Any, speed_mps: float) -> None:
        """Sets the speed at the radius from the next physics step on; counter-clockwise is > 0."""
        plate = physics.bind(*self.solid_geoms).element_id
        physics.model.geom_surfacevel[plate, 5] = speed_mps / RADIUS_M

    def initialize_episode(self, physics: Any, random_state: np.random.RandomState) -> None:
        """Composer's hook: the drawn disc starts at its mark."""
        del random_state
        self.show_mark(physics)

    def show_mark(self, physics: Any) -> None:
        """Puts the drawn disc to its mark."""
        self._turn_rad, self._shown_at_s = 0.0, float(physics.time())
        self._show_turn(physics)

    def after_step(self, physics: Any, random_state: np.random.RandomState) -> None:
        """Composer's hook: the drawn disc turns as far as the surface has."""
        del random_state
        rate = self.speed_mps(physics) / RADIUS_M
        self._turn_rad += rate * (physics.time() - self._shown_at_s)
        self._shown_at_s = float(physics.time())
        self._show_turn(physics)

    def _show_turn(self, physics: Any) -> None:
        """Turns the picture of the disc, from the next physics step on."""
        disc = physics.bind(self._disc).element_id
        # Written past the binding, which would have the whole scene computed anew.
        physics.model.body_quat[disc] = yaw_quaternion(self._turn_rad)
