"""The arm models against what their maker publishes, re-typed here so that a slip shows."""

from dataclasses import dataclass

import mujoco
import numpy as np
import pytest
from dm_control import mjcf

from sim.arm.embodiments import JOINT_NAMES, UR3_SOFT, UR5_RG2, Arm, Embodiment
from sim.arm.robot import Robot

LINKS = ("shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3")


@dataclass(frozen=True)
class Published:
    """Numbers of [URDescription]."""

    embodiment: Embodiment
    mass_kg: tuple
    com_m: tuple
    inertia_kgm2: tuple
    torque_nm: tuple
    speed_deg_s: tuple
    limit_rad: tuple

    @property
    def arm(self) -> Arm:
        return self.embodiment.arm


UR5 = Published(
    UR5_RG2,
    (3.7, 8.393, 2.33, 1.219, 1.219, 0.1879),
    (
        (0.0, -0.00193, -0.02561),
        (-0.2125, 0.0, 0.11336),
        (-0.24225, 0.0, 0.0265),
        (0.0, -0.01634, -0.0018),
        (0.0, 0.01634, -0.0018),
        (0.0, 0.0, -0.001159),
    ),
    (
        (0.0149724, 0.0149724, 0.0104063),
        (0.1338858, 0.1338858, 0.0151074),
        (0.0312168, 0.0312168, 0.004095),
        (0.0020139, 0.0020139, 0.0021942),
        (0.0018310, 0.0018310, 0.0021942),
        (8.0625e-5, 8.0625e-5, 1.3212e-4),
    ),
    (150, 150, 150, 28, 28, 28),
    (180,) * 6,
    (2 * np.pi, 2 * np.pi, np.pi, 2 * np.pi, 2 * np.pi, 2 * np.pi),
)

UR3 = Published(
    UR3_SOFT,
    (2.0, 3.42, 1.26, 0.8, 0.8, 0.35),
    (
        (0.0, 0.0, -0.02),
        (-0.11365, 0.0, 0.1157),
        (-0.16325, 0.0, 0.0238),
        (0.0, -0.01, 0.0),
        (0.0, 0.01, 0.0),
        (0.0, 0.0, -0.02),
    ),
    (
        (0.0080932, 0.0080932, 0.005625),
        (0.0217285, 0.0217285, 0.0096188),
        (0.0065468, 0.0065468, 0.0035438),
        (0.0016106, 0.0016106, 0.00225),
        (0.0015722, 0.0015722, 0.00225),
        (1.36267e-4, 1.36267e-4, 1.792e-4),
    ),
    (56, 56, 28, 12, 12, 12),
    (180, 180, 180, 360, 360, 360),
    (2 * np.pi, 2 * np.pi, np.pi, 2 * np.pi, 2 * np.pi, np.inf),
)


@pytest.fixture(scope="module", params=[UR5, UR3], ids=["ur5", "ur3"])
def arm(request):
    robot = Robot(request.param.embodiment)
    return request.param, robot, mjcf.Physics.from_mjcf_model(robot.mjcf_model)


def test_flange_follows_the_published_dh_chain(arm):
    published, robot, physics = arm
    rng = np.random.default_rng(0)
    for _ in range(200):
        q = rng.uniform(-np.pi, np.pi, 6)
        robot.set_configuration(physics, q, 0.1)
        mujoco.mj_kinematics(physics.model.ptr, physics.data.ptr)
        flange = physics.bind(robot.flange_site)
        T = published.arm.forward(q)
        np.testing.assert_allclose(flange.xpos, T[:3, 3], atol=1e-9)
        np.testing.assert_allclose(flange.xmat.reshape(3, 3), T[:3, :3], atol=1e-9)


def test_stretched_out_the_arm_is_as_long_as_its_table():
    """Upper arm and forearm level, wrist 2 at zero: lengths add up along x, offsets along y."""
    T = UR3.arm.forward(np.zeros(6))
    np.testing.assert_allclose(
        T[:3, 3], [0.24365 + 0.21325, 0.11235 + 0.0819, 0.1519 - 0.08535], atol=1e-12
    )


def test_links_have_the_published_masses(arm):
    published, robot, physics = arm
    bound = physics.bind([robot.mjcf_model.find("body", name) for name in LINKS])
    np.testing.assert_allclose(bound.mass, published.mass_kg)
    np.testing.assert_allclose(bound.ipos, published.com_m, atol=1e-12)
    expected = np.sort(np.array(published.inertia_kgm2), axis=1)
    np.testing.assert_allclose(np.sort(bound.inertia, axis=1), expected, rtol=5e-5)


def test_inertia_of_the_tubes_is_small_about_the_tube(arm):
    _, robot, physics = arm
    for name in ("upper_arm", "forearm"):
        body = physics.bind(robot.mjcf_model.find("body", name))
        R = np.empty(9)
        mujoco.mju_quat2Mat(R, body.iquat)
        R = R.reshape(3, 3)
        about_tube = (R @ np.diag(body.inertia) @ R.T)[0, 0]
        assert about_tube == pytest.approx(min(body.inertia), rel=1e-6)


def test_limits_are_the_published_ones(arm):
    published, robot, physics = arm
    joints = physics.bind(robot.arm_joints)
    upper = np.where(joints.limited, joints.range[:, 1], np.inf)
    np.testing.assert_allclose(upper, published.limit_rad)
    np.testing.assert_allclose(joints.range[:, 0], -joints.range[:, 1])
    servos = physics.bind(robot.arm_actuators)
    np.testing.assert_array_equal(servos.forcerange[:, 1], published.torque_nm)
    np.testing.assert_array_equal(servos.forcerange[:, 0], np.negative(published.torque_nm))
    np.testing.assert_allclose(np.degrees(published.arm.joint_speed_radps), published.speed_deg_s)
    assert tuple(joint.name for joint in robot.arm_joints) == JOINT_NAMES
