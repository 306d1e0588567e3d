"""The world as a dm_env environment, and the arm alone as a kinematic model for the servo."""

import mujoco
import numpy as np
from dm_control import composer, mjcf

from sim.arm.embodiments import UR5_RG2, Embodiment
from sim.arm.robot import Robot
from sim.arm.servo import Servo, ServoConfig
from sim.belt.arena import Cell
from sim.belt.carriers import CARRIERS
from sim.belt.task import ConveyorGrasp
from sim.belt.task_config import TaskConfig
from sim.checks import look_up

TIME_LIMIT_S = 30.0
"""No attempt lasts longer than this in simulated time."""


def load(
    config: TaskConfig | None = None, random_state: np.random.RandomState | int | None = None
) -> composer.Environment:
    """The conveyor cell as a `dm_env` environment.

    Args:
        config: The cell; the default one where None.
        random_state: Draws the scenarios of episodes that are not set by hand.
    """
    return composer.Environment(
        ConveyorGrasp(config or TaskConfig()),
        time_limit=TIME_LIMIT_S,
        random_state=random_state,
        recompile_mjcf_every_episode=False,
        strip_singleton_obs_buffer_dim=True,
    )


def make_servo(
    embodiment: Embodiment = UR5_RG2,
    carrier_name: str = "belt",
    config: ServoConfig | None = None,
) -> Servo:
    """A servo on the cell's own arm, hand and carrier, with the fingers fixed at full opening."""
    arena, robot = Cell(embodiment), Robot(embodiment, fixed_fingers=True)
    carrier = look_up("carrier", carrier_name, CARRIERS)()
    arena.attach_robot(robot)
    arena.attach_carrier(carrier)
    model: mujoco.MjModel = mjcf.Physics.from_mjcf_model(arena.mjcf_model).model.ptr
    return Servo(
        model,
        config or ServoConfig(),
        joint_speed_radps=embodiment.arm.joint_speed_radps,
        tcp_site=robot.tcp_site.full_identifier,
        hand_geoms=[geom.full_identifier for geom in robot.hand_geoms],
        belt_geoms=[geom.full_identifier for geom in carrier.solid_geoms],
    )
