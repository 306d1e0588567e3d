"""Belt conveyor: a still geom with a surface velocity, between passive rails."""

from __future__ import annotations

from typing import Any

import numpy as np
from dm_control import composer, mjcf

from sim import ASSETS, textures

BELT_CENTRE_X_M = 0.50
"""World x of the centreline; the belt runs along +y and carries at z = 0."""

BELT_WIDTH_M = 0.40
BELT_Y_MIN_M = -1.30
BELT_Y_MAX_M = 1.30

_PATTERN_PERIOD_M = 0.1


class Conveyor(composer.Entity):
    """Conveyor; its frame is the centre of the carrying surface, y along the belt."""

    def _build(self) -> None:
        self._mjcf_root = mjcf.from_path(str(ASSETS / "conveyor.xml"))
        self._belt = self._mjcf_root.find("geom", "belt")
        self._band = self._mjcf_root.find("geom", "band")
        textures.apply(self._mjcf_root, "rubber", textures.belt_surface())
        self._travel_m, self._shown_at_s = 0.0, 0.0
        self._rails = tuple(
            self._mjcf_root.find("geom", f"rail_{side}") for side in ("near", "far")
        )

    @property
    def mjcf_model(self) -> Any:
        """PyMJCF model of the conveyor."""
        return self._mjcf_root

    @property
    def belt_geom(self) -> Any:
        """The carrying geom."""
        return self._belt

    @property
    def rail_geoms(self) -> tuple[Any, ...]:
        """Near (robot side) and far rail."""
        return self._rails

    def set_speed(self, physics: Any, speed_mps: float) -> None:
        """Sets the surface velocity of the belt along +y from the next physics step on."""
        physics.model.geom_surfacevel[physics.bind(self._belt).element_id, 1] = speed_mps

    def initialize_episode(self, physics: Any, random_state: np.random.RandomState) -> None:
        """Composer's hook."""
        del random_state
        self.rewind(physics)

    def rewind(self, physics: Any) -> None:
        """Puts the drawn belt at its mark."""
        self._travel_m, self._shown_at_s = 0.0, float(physics.time())
        self._show_travel(physics)

    def after_step(self, physics: Any, random_state: np.random.RandomState) -> None:
        """Composer's hook: the drawn belt moves as far as the surface has."""
        del random_state
        speed_mps = physics.model.geom_surfacevel[physics.bind(self._belt).element_id, 1]
        self._travel_m += speed_mps * (physics.time() - self._shown_at_s)
        self._shown_at_s = float(physics.time())
        self._show_travel(physics)

    def _show_travel(self, physics: Any) -> None:
        """Shifts the picture of the belt within one period of its pattern; no effect on physics."""
        shift_m = (self._travel_m + 0.5 * _PATTERN_PERIOD_M) % _PATTERN_PERIOD_M
        offset_m = shift_m - 0.5 * _PATTERN_PERIOD_M
        band = physics.bind(self._band).element_id
        # Written past the binding, which would have the whole scene computed anew.
        physics.model.geom_sameframe[band] = 0
        physics.data.geom_xpos[band, 1] += offset_m - physics.model.geom_pos[band, 1]
        physics.model.geom_pos[band, 1] = offset_m
