"""The cell: floor, pedestal, sky, lights and the options of physics and rendering."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from dm_control import composer, mjcf

from sim.conveyor import BELT_CENTRE_X_M, Conveyor
from sim.robot import Robot

PHYSICS_STEP_S = 1.0 / 480.0

BASE_HEIGHT_M = 0.15
"""Height of the robot's mounting face above the carrying surface of the belt."""

FLOOR_Z_M = -0.75

EXTENT_M = 2.0
"""Model extent: the near and far planes are multiples of it."""

ZNEAR_M = 0.04
ZFAR_M = 20.0


class Cell(composer.Arena):
    """Work cell with a place for the robot and one for the conveyor."""

    def _build(self, shadows: bool = False) -> None:
        """Makes the room.

        Args:
            shadows: Whether the key light casts shadows, which doubles the cost of an image.
        """
        self._mjcf_root = mjcf.RootElement(model="cell")
        self._set_options()
        self._add_lights(shadows)
        self._add_room()

    def _set_options(self) -> None:
        root = self._mjcf_root
        root.compiler.angle = "radian"
        option = root.option
        option.timestep = PHYSICS_STEP_S
        option.integrator = "implicitfast"
        option.cone = "elliptic"
        option.impratio = 10
        option.solver = "Newton"
        root.statistic.extent = EXTENT_M
        root.statistic.center = (BELT_CENTRE_X_M, 0.0, 0.0)
        visual = root.visual
        visual.map.znear = ZNEAR_M / EXTENT_M
        visual.map.zfar = ZFAR_M / EXTENT_M
        visual.quality.offsamples = 0
        visual.quality.shadowsize = 1024
        visual.headlight.ambient = (0.3, 0.3, 0.3)
        visual.headlight.diffuse = (0.0, 0.0, 0.0)
        visual.headlight.specular = (0.0, 0.0, 0.0)
        getattr(visual, "global").offwidth = 1920
        getattr(visual, "global").offheight = 1080

    def _add_lights(self, shadows: bool) -> None:
        add = self._mjcf_root.worldbody.add
        self._lights = (
            add(
                "light",
                name="key",
                pos=(1.6, -1.2, 2.6),
                dir=(-0.45, 0.4, -1.0),
                diffuse=(0.7, 0.7, 0.68),
                specular=(0.3, 0.3, 0.3),
                directional=True,
                castshadow=shadows,
            ),
            add(
                "light",
                name="fill",
                pos=(-0.5, 1.5, 2.2),
                dir=(0.4, -0.6, -1.0),
                diffuse=(0.25, 0.27, 0.3),
                specular=(0.0, 0.0, 0.0),
                directional=True,
                castshadow=False,
            ),
        )

    def _add_room(self) -> None:
        add = self._mjcf_root.worldbody.add
        add(
            "geom",
            name="floor",
            type="plane",
            size=(4.0, 4.0, 0.1),
            pos=(0.0, 0.0, FLOOR_Z_M),
            contype=1,
            conaffinity=14,
            rgba=(0.5, 0.5, 0.52, 1.0),
        )
        height = BASE_HEIGHT_M - FLOOR_Z_M
        add(
            "geom",
            name="pedestal",
            type="cylinder",
            size=(0.09, 0.5 * height),
            pos=(0.0, 0.0, BASE_HEIGHT_M - 0.5 * height),
            contype=1,
            conaffinity=14,
            rgba=(0.25, 0.26, 0.28, 1.0),
        )

    @property
    def lights(self) -> tuple[Any, Any]:
        """The light elements `key` and `fill`."""
        return self._lights

    def attach_robot(self, robot: Robot) -> Any:
        """Stands the robot on its pedestal at the origin; returns the attachment frame."""
        site = self._mjcf_root.worldbody.add("site", pos=(0, 0, BASE_HEIGHT_M), size=(0.001,) * 3)
        return self.attach(robot, site)

    def attach_conveyor(self, conveyor: Conveyor) -> Any:
        """Puts the belt in front of the robot; returns the attachment frame."""
        site = self._mjcf_root.worldbody.add("site", pos=(BELT_CENTRE_X_M, 0, 0), size=(0.001,) * 3)
        return self.attach(conveyor, site)

    def set_light_scale(self, physics: Any, scale: float) -> None:
        """Dims (or brightens) every light of the cell, 1 being the compiled brightness."""
        if not (math.isfinite(scale) and scale >= 0.0):
            raise ValueError(f"scale must be finite and >= 0, got {scale!r}")
        for light in self._lights:
            physics.bind(light).diffuse = scale * np.asarray(light.diffuse)
            physics.bind(light).specular = scale * np.asarray(light.specular)
        ambient = self._mjcf_root.visual.headlight.ambient
        physics.model.vis.headlight.ambient[:] = scale * np.asarray(ambient)
