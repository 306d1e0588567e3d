"""The compiled cell that the tests of its parts share."""

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import pytest
from dm_control import mjcf

from sim.arm.embodiments import UR3_SOFT, UR5_RG2, Embodiment
from sim.arm.robot import Robot
from sim.belt.arena import Cell
from sim.belt.carriers import Conveyor
from sim.belt.objects import OBJECTS, Prop
from sim.belt.task import CONTROL_HZ, PHYSICS_HZ


@dataclass(frozen=True, eq=False)
class Scene:
    """Cell, robot at home, conveyor and box; the belt stands still."""

    embodiment: Embodiment
    cell: Cell
    robot: Robot
    conveyor: Conveyor
    box: Prop
    physics: Any

    def restart(self) -> "Scene":
        """Puts everything back to its start."""
        with self.physics.reset_context():
            self.robot.go_home(self.physics)
            self.place_box(0.50, -1.10)
            self.conveyor.set_speed(self.physics, 0.0)
        return self

    def place_box(self, x_m: float, y_m: float, yaw_rad: float = 0.0, z_m: float = 0.04) -> None:
        """Puts the box there, at rest."""
        joint = self.box_joint
        joint.qpos = [x_m, y_m, z_m, np.cos(0.5 * yaw_rad), 0.0, 0.0, np.sin(0.5 * yaw_rad)]
        joint.qvel = 0.0

    def step(self, duration_s: float) -> None:
        """Advances the physics."""
        self.physics.step(round(duration_s / self.physics.timestep()))

    def close_fingers(self, duration_s: float = 0.6) -> None:
        """Ramps the opening to zero as the real gripper would."""
        width = self.robot.width_m(self.physics)
        for _ in range(round(duration_s * CONTROL_HZ)):
            width = max(0.0, width - self.embodiment.gripper.speed_mps / CONTROL_HZ)
            self.robot.command_width(self.physics, width)
            self.physics.step(PHYSICS_HZ // CONTROL_HZ)

    def finger_forces(self) -> list[float]:
        """Normal force [N] of the right and the left pad on the box."""
        model, data = self.physics.model, self.physics.data
        totals = []
        for pad in self.robot.pad_geoms:
            total, wrench = 0.0, np.empty(6)
            for index, contact in enumerate(data.contact):
                names = {model.id2name(g, "geom") for g in (contact.geom1, contact.geom2)}
                if pad.full_identifier in names and "box/body" in names:
                    mujoco.mj_contactForce(model.ptr, data.ptr, index, wrench)
                    total += wrench[0]
            totals.append(total)
        return totals

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


def compile_scene(embodiment: Embodiment) -> Scene:
    """A scene of its own."""
    cell, robot = Cell(embodiment), Robot(embodiment)
    conveyor, box = Conveyor(), Prop(OBJECTS["box"])
    cell.attach_robot(robot)
    cell.attach_carrier(conveyor)
    cell.add_free_entity(box)
    return Scene(
        embodiment, cell, robot, conveyor, box, mjcf.Physics.from_mjcf_model(cell.mjcf_model)
    )


@pytest.fixture(scope="session")
def compiled_scene() -> Scene:
    return compile_scene(UR5_RG2)


@pytest.fixture(scope="session")
def compiled_soft_scene() -> Scene:
    return compile_scene(UR3_SOFT)


@pytest.fixture
def scene(compiled_scene: Scene) -> Scene:
    """The shared scene, put back to its start."""
    return compiled_scene.restart()


@pytest.fixture
def soft_scene(compiled_soft_scene: Scene) -> Scene:
    """The shared scene of the UR3 and the soft gripper, put back to its start."""
    return compiled_soft_scene.restart()
