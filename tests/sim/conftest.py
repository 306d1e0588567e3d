"""The compiled cell that the tests of its parts share."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from dm_control import mjcf

from sim.arena import Cell
from sim.conveyor import Conveyor
from sim.objects import OBJECTS, Prop
from sim.robot import HOME_Q_RAD, STROKE_M, Robot


@dataclass(frozen=True, eq=False)
class Scene:
    """Cell, robot at home, conveyor and box; the belt stands still."""

    cell: Cell
    robot: Robot
    conveyor: Conveyor
    box: Prop
    physics: Any

    def place_box(self, x_m: float, y_m: float, yaw_rad: float = 0.0, z_m: float = 0.04) -> None:
        """Puts the box there, at rest."""
        joint = self.box_joint
        joint.qpos = [x_m, y_m, z_m, np.cos(0.5 * yaw_rad), 0.0, 0.0, np.sin(0.5 * yaw_rad)]
        joint.qvel = 0.0

    def step(self, duration_s: float) -> None:
        """Advances the physics."""
        self.physics.step(round(duration_s / self.physics.timestep()))

    @property
    def box_joint(self) -> Any:
        """Bound free joint of the box: qpos (7,), qvel (6,)."""
        return self.physics.bind(mjcf.get_frame_freejoint(self.box.mjcf_model))

    @property
    def contacts(self) -> set[tuple[str, str]]:
        """Names of the geoms that touch, each pair sorted."""
        model, data = self.physics.model, self.physics.data
        return {
            tuple(sorted(model.id2name(geom, "geom") for geom in (c.geom1, c.geom2)))
            for c in data.contact
        }


@pytest.fixture(scope="session")
def compiled_scene() -> Scene:
    cell, robot, conveyor, box = Cell(), Robot(), Conveyor(), Prop(OBJECTS["box"])
    cell.attach_robot(robot)
    cell.attach_carrier(conveyor)
    cell.add_free_entity(box)
    return Scene(cell, robot, conveyor, box, mjcf.Physics.from_mjcf_model(cell.mjcf_model))


@pytest.fixture
def scene(compiled_scene: Scene) -> Scene:
    """The shared scene, put back to its start."""
    with compiled_scene.physics.reset_context():
        compiled_scene.robot.set_configuration(compiled_scene.physics, HOME_Q_RAD, STROKE_M)
        compiled_scene.place_box(0.50, -1.10)
        compiled_scene.conveyor.set_speed(compiled_scene.physics, 0.0)
    return compiled_scene
