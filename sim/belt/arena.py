"""The work cell: room, lights, and the options of physics and rendering."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from dm_control import composer, mjcf

from sim import ASSETS, textures
from sim.arm.embodiments import UR5_RG2, Embodiment
from sim.arm.robot import Robot
from sim.belt.carriers import Carrier
from sim.world_config import PHYSICS_HZ

PHYSICS_STEP_S = 1.0 / PHYSICS_HZ
FLOOR_Z_M = -0.75


class Cell(composer.Arena):
    """Work cell with a place for the robot and one for what carries the object."""

    def _build(self, embodiment: Embodiment = UR5_RG2) -> None:
        self._mjcf_root = mjcf.from_path(str(ASSETS / "cell.xml"))
        self._raise_pedestal(embodiment)
        textures.apply(self._mjcf_root, "concrete", textures.concrete())
        textures.apply(self._mjcf_root, "busy", textures.busy_print())
        self.lights = tuple(self._mjcf_root.find("light", name) for name in ("key", "fill"))
        """The light elements `key`, which can cast shadows, and `fill`, which does not."""

    def attach_robot(self, robot: Robot) -> Any:
        """Stands the robot on its pedestal; returns the attachment frame."""
        return self.attach(robot, self._mjcf_root.find("site", "robot"))

    def attach_carrier(self, carrier: Carrier) -> Any:
        """Puts the belt or the turntable in front of the robot; returns the attachment frame."""
        return self.attach(carrier, self._mjcf_root.find("site", "carrier"))

    def set_clutter(self, physics: Any, opacity: float) -> None:
        """Shows a busy print on the floor, 0 for none and 1 for all of it."""
        floor = physics.bind(self._mjcf_root.find("geom", "busy_floor")).element_id
        physics.model.geom_rgba[floor, 3] = opacity

    def _raise_pedestal(self, embodiment: Embodiment) -> None:
        """Puts the pedestal under the embodiment's mounting face."""
        x, top = embodiment.base_x_m, embodiment.base_height_m
        half = 0.5 * (top - FLOOR_Z_M)
        heights = {"pedestal": top - half, "pedestal_cap": top - 0.011, "pedestal_foot": -0.74}
        for name, z in heights.items():
            geom = self._mjcf_root.find("geom", name)
            geom.pos = x, 0.0, z
            # The model's own pedestal has the radius of the UR5's.
            geom.size[0] *= embodiment.pedestal_radius_m / UR5_RG2.pedestal_radius_m
        self._mjcf_root.find("geom", "pedestal").size[1] = half
        self._mjcf_root.find("site", "robot").pos = x, 0.0, top

    def set_light_scale(self, physics: Any, scale: float) -> None:
        """Dims (or brightens) every light of the cell, 1 being the compiled brightness."""
        if not (math.isfinite(scale) and scale >= 0.0):
            raise ValueError(f"scale must be finite and >= 0, got {scale!r}")
        model = physics.model
        for light in self.lights:
            # Written past the binding, which would have the whole scene computed anew.
            index = physics.bind(light).element_id
            model.light_diffuse[index] = scale * np.asarray(light.diffuse)
            model.light_specular[index] = scale * np.asarray(light.specular)
        ambient = self._mjcf_root.visual.headlight.ambient
        model.vis.headlight.ambient[:] = scale * np.asarray(ambient)
