"""The soft gripper against mechanics: springs, rated force, friction, a box lifted off the belt."""

import numpy as np
import pytest

from sim.arm.embodiments import SOFT
from sim.belt.task import CONTROL_HZ, PHYSICS_HZ

GRASP_Q_RAD = np.array([-0.761851, -0.664427, 1.960211, -2.866581, -1.570796, -0.761851])
"""Hand down, tcp at (0.50, -0.15, 0.045) in the world, closing along x."""
LIFTED_Q_RAD = np.array([-0.761851, -1.333563, 1.778723, -2.015956, -1.570796, -0.761851])
"""The same, 0.20 m higher."""

STIFFNESS_NM_PER_RAD = 5.0
HINGE_TO_PAD_M = 0.07
BOX_WEIGHT_N = 0.5 * 9.81


def bends(scene) -> np.ndarray:
    """(2,) angles of the fingers, 0 where they are straight."""
    return np.array(scene.physics.bind(scene.robot.finger_springs).qpos)


@pytest.fixture
def grasp(soft_scene):
    """The hand closed on the box where it stands, lying along the belt."""
    with soft_scene.physics.reset_context():
        soft_scene.robot.set_configuration(soft_scene.physics, GRASP_Q_RAD, SOFT.stroke_m)
        soft_scene.place_box(0.50, -0.15, np.pi / 2)
    soft_scene.close_fingers(1.0)
    return soft_scene


@pytest.fixture
def held(grasp):
    """The box 0.20 m above the belt."""
    for k in range(CONTROL_HZ):
        blend = min(1.0, k / 90)
        q = GRASP_Q_RAD + blend * (LIFTED_Q_RAD - GRASP_Q_RAD)
        grasp.robot.command_arm(grasp.physics, q, np.zeros(6))
        grasp.physics.step(PHYSICS_HZ // CONTROL_HZ)
    grasp.step(0.5)
    return grasp


def test_force_at_the_pad_bends_the_finger_by_force_over_stiffness(soft_scene):
    """k θ = F l with the lever l of the force about the hinge; the pad gives way by F l² / k."""
    physics, robot = soft_scene.physics, soft_scene.robot
    pad = physics.bind(robot.pad_geoms[0])
    body = physics.bind(robot.mjcf_model.find("body", "soft/right_bend"))
    rest, start_m = bends(soft_scene)[0], (np.array(pad.xpos) - body.xpos)[0]
    for force_n in (1.0, 3.0, 6.0):
        for _ in range(PHYSICS_HZ):
            torque = np.cross(np.array(pad.xpos) - body.xipos, [force_n, 0.0, 0.0])
            body.xfrc_applied = [force_n, 0.0, 0.0, *torque]
            physics.step()
        across_m, _, below_m = np.array(pad.xpos) - body.xpos
        turn = bends(soft_scene)[0] - rest
        assert turn == pytest.approx(force_n * -below_m / STIFFNESS_NM_PER_RAD, rel=0.01)
        given_m = force_n * HINGE_TO_PAD_M**2 / STIFFNESS_NM_PER_RAD
        assert across_m - start_m == pytest.approx(given_m, rel=0.1)
    body.xfrc_applied = np.zeros(6)
    soft_scene.step(1.0)
    assert bends(soft_scene)[0] == pytest.approx(rest, abs=1e-3)


def test_open_pads_leave_room_for_the_box(soft_scene):
    right, left = soft_scene.physics.bind(soft_scene.robot.pad_geoms).xpos
    assert np.linalg.norm(right - left) - 0.008 == pytest.approx(0.12, abs=0.002)


def test_rated_force_makes_the_fingers_straight(held):
    np.testing.assert_allclose(held.finger_forces(), SOFT.force_n, rtol=0.02)
    np.testing.assert_allclose(bends(held), 0.0, atol=0.02)
    assert held.robot.width_m(held.physics) == pytest.approx(0.080, abs=0.002)


def test_box_is_lifted_and_held_by_the_pads_alone(held):
    assert held.box_joint.qpos[2] > 0.22
    touching = {name for pair in held.contacts for name in pair}
    assert touching == {"box/body", "ur3/soft/right_pad", "ur3/soft/left_pad"}
    before = held.box_joint.qpos[2]
    held.step(2.0)
    assert abs(held.box_joint.qpos[2] - before) < 2e-4


@pytest.mark.parametrize(("share", "holds"), [(0.85, True), (1.15, False)])
def test_friction_ends_at_the_limit_of_coulomb(held, share, holds):
    """Two pads carry 2 μ F; pulled down by more than what the weight leaves, the box slides."""
    limit_n = 2.0 * 0.8 * SOFT.force_n
    body = held.physics.bind(held.box.body)
    before = held.box_joint.qpos[2]
    body.xfrc_applied = [0.0, 0.0, -(share * limit_n - BOX_WEIGHT_N), 0.0, 0.0, 0.0]
    held.step(0.5)
    slid_m = before - held.box_joint.qpos[2]
    body.xfrc_applied = np.zeros(6)
    assert (slid_m < 0.01) == holds
