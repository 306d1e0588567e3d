"""Belt conveyor: a still geom with a surface velocity, between passive rails."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from dm_control import composer, mjcf

from sim import ASSETS, textures
from sim.belt.path import Pose

BELT_CENTRE_X_M = 0.50
"""World x of the centreline; the belt runs along +y and carries at z = 0."""

BELT_WIDTH_M = 0.40

_PATTERN_PERIOD_M = 0.1
_BUSY_PERIOD_M = 0.4


class Conveyor(composer.Entity):
    """Conveyor; its frame is the centre of the carrying surface, y along the belt."""

    def _build(self) -> None:
        self._mjcf_root = mjcf.from_path(str(ASSETS / "conveyor.xml"))
        self.belt_geom: Any = self._mjcf_root.find("geom", "belt")
        """The carrying geom."""
        self.rail_geoms = self._both("rail")
        """Near (robot side) and far rail."""
        self.solid_geoms = (self.belt_geom, *self.rail_geoms)
        """Belt and rails."""
        self._band = self._mjcf_root.find("geom", "band")
        textures.apply(self._mjcf_root, "rubber", textures.belt_surface())
        self._busy_band = self._mjcf_root.find("geom", "busy_band")
        self._busy_rails = self._both("busy_rail")
        textures.apply(self._mjcf_root, "busy", textures.busy_print())
        self._travel_m, self._shown_at_s = 0.0, 0.0

    def _both(self, name: str) -> tuple[Any, ...]:
        return tuple(self._mjcf_root.find("geom", f"{name}_{side}") for side in ("near", "far"))

    @property
    def mjcf_model(self) -> Any:
        """PyMJCF model of the conveyor."""
        return self._mjcf_root

    @property
    def face_range_m(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Least and largest world x, then y, between which the face of an object can be seen."""
        half_m = 0.5 * BELT_WIDTH_M + 0.02
        return (BELT_CENTRE_X_M - half_m, BELT_CENTRE_X_M + half_m), (-0.85, 0.85)

    def carried(self, pose: Pose, way_m: float) -> Pose:
        """Returns the later pose of what rides at `pose`, the surface moved on by `way_m`."""
        return replace(pose, y_m=pose.y_m + way_m)

    def velocity_at(self, pose: Pose, speed_mps: float) -> tuple[float, float, float]:
        """Returns world x, y velocity [m/s] and yaw rate [rad/s] of what rides there."""
        del pose
        return 0.0, speed_mps, 0.0

    def speed_mps(self, physics: Any) -> float:
        """Speed of the surface."""
        return float(physics.model.geom_surfacevel[physics.bind(self.belt_geom).element_id, 1])

    def set_clutter(self, physics: Any, opacity: float) -> None:
        """Shows a busy print on belt and rails, 0 for none and 1 for all of it."""
        for geom in (self._busy_band, *self._busy_rails):
            physics.model.geom_rgba[physics.bind(geom).element_id, 3] = opacity

    def set_speed(self, physics: Any, speed_mps: float) -> None:
        """Sets the surface velocity of the belt along +y from the next physics step on."""
        physics.model.geom_surfacevel[physics.bind(self.belt_geom).element_id, 1] = speed_mps

    def initialize_episode(self, physics: Any, random_state: np.random.RandomState) -> None:
        """Composer's hook: the drawn belt starts at its mark."""
        del random_state
        self.show_mark(physics)

    def show_mark(self, physics: Any) -> None:
        """Puts the drawn belt to its mark."""
        self._travel_m, self._shown_at_s = 0.0, float(physics.time())
        self._show_travel(physics)

    def after_step(self, physics: Any, random_state: np.random.RandomState) -> None:
        """Composer's hook: the drawn belt moves as far as the surface has."""
        del random_state
        self._travel_m += self.speed_mps(physics) * (physics.time() - self._shown_at_s)
        self._shown_at_s = float(physics.time())
        self._show_travel(physics)

    def _show_travel(self, physics: Any) -> None:
        """Shifts the pictures of the belt within their patterns' periods; no effect on physics."""
        for geom, period_m in ((self._band, _PATTERN_PERIOD_M), (self._busy_band, _BUSY_PERIOD_M)):
            offset_m = (self._travel_m + 0.5 * period_m) % period_m - 0.5 * period_m
            band = physics.bind(geom).element_id
            # Written past the binding, which would have the whole scene computed anew.
            physics.model.geom_sameframe[band] = 0
            physics.data.geom_xpos[band, 1] += offset_m - physics.model.geom_pos[band, 1]
            physics.model.geom_pos[band, 1] = offset_m
