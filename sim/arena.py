"""The work cell: room, lights, and the options of physics and rendering."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from dm_control import composer, mjcf

from sim import ASSETS, textures
from sim.carriers import Carrier
from sim.robot import Robot

PHYSICS_STEP_S = 1.0 / 480.0

BASE_HEIGHT_M = 0.15
"""Height of the robot's mounting face above the carrying surface of the belt."""

FLOOR_Z_M = -0.75

ZNEAR_M = 0.04
ZFAR_M = 20.0


class Cell(composer.Arena):
    """Work cell with a place for the robot and one for what carries the object."""

    def _build(self) -> None:
        self._mjcf_root = mjcf.from_path(str(ASSETS / "cell.xml"))
        textures.apply(self._mjcf_root, "concrete", textures.concrete())
        textures.apply(self._mjcf_root, "busy", textures.busy_print())
        self._lights = tuple(self._mjcf_root.find("light", name) for name in ("key", "fill"))

    @property
    def lights(self) -> tuple[Any, ...]:
        """The light elements `key`, which can cast shadows, and `fill`, which does not."""
        return self._lights

    def attach_robot(self, robot: Robot) -> Any:
        """Stands the robot on its pedestal at the origin; returns the attachment frame."""
        return self.attach(robot, self._mjcf_root.find("site", "robot"))

    def attach_carrier(self, carrier: Carrier) -> Any:
        """Puts the belt or the turntable in front of the robot; returns the attachment frame."""
        return self.attach(carrier, self._mjcf_root.find("site", "carrier"))

    def set_clutter(self, physics: Any, opacity: float) -> None:
        """Shows a busy print on the floor, 0 for none and 1 for all of it."""
        floor = physics.bind(self._mjcf_root.find("geom", "busy_floor")).element_id
        physics.model.geom_rgba[floor, 3] = opacity

    def set_light_scale(self, physics: Any, scale: float) -> None:
        """Dims (or brightens) every light of the cell, 1 being the compiled brightness."""
        if not (math.isfinite(scale) and scale >= 0.0):
            raise ValueError(f"scale must be finite and >= 0, got {scale!r}")
        model = physics.model
        for light in self._lights:
            # Written past the binding, which would have the whole scene computed anew.
            index = physics.bind(light).element_id
            model.light_diffuse[index] = scale * np.asarray(light.diffuse)
            model.light_specular[index] = scale * np.asarray(light.specular)
        ambient = self._mjcf_root.visual.headlight.ambient
        model.vis.headlight.ambient[:] = scale * np.asarray(ambient)
