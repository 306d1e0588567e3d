import mujoco
import numpy as np
import pytest
from dm_control import mjcf

from sim.arm.embodiments import RG2, UR5_RG2
from sim.arm.robot import Robot
from sim.belt.task import CONTROL_HZ

CONTROL_STEP_S = 1.0 / CONTROL_HZ

GRASP_Q_RAD = np.array([-0.728721, -1.062806, 1.869447, -2.377437, -1.570796, -0.728721])
"""Hand down, tcp at (0.50, -0.30, 0.045) in the world, closing along x."""


def test_tcp_lies_between_the_pads(scene):
    tcp = scene.physics.bind(scene.robot.tcp_site)
    pads = scene.physics.bind(scene.robot.pad_geoms).xpos
    np.testing.assert_allclose(pads.mean(axis=0), tcp.xpos, atol=1e-9)
    closing_axis = pads[0] - pads[1]
    closing_axis /= np.linalg.norm(closing_axis)
    np.testing.assert_allclose(closing_axis, tcp.xmat.reshape(3, 3)[:, 0], atol=1e-9)


def test_fingertips_clear_the_belt_at_grasp_height(scene):
    scene.robot.set_configuration(scene.physics, GRASP_Q_RAD, RG2.stroke_m)
    scene.physics.forward()
    geoms = scene.physics.bind(scene.robot.hand_geoms)
    for position, xmat, size in zip(geoms.xpos, geoms.xmat, geoms.size, strict=True):
        lowest = position[2] - np.abs(xmat.reshape(3, 3)[2]) @ size
        assert lowest >= 0.010
    assert scene.physics.bind(scene.robot.tcp_site).xpos[2] == pytest.approx(0.045, abs=1e-5)


def test_fixed_fingers_leave_the_six_joints_of_the_arm(scene):
    robot = Robot(fixed_fingers=True)
    physics = mjcf.Physics.from_mjcf_model(robot.mjcf_model)
    assert (physics.model.nq, physics.model.nv, physics.model.nu) == (6, 6, 6)
    assert physics.model.neq == physics.model.ntendon == 0
    assert robot.finger_joints == ()
    assert robot.gripper_actuator is None
    physics.bind(robot.arm_joints).qpos = UR5_RG2.home_q_rad
    mujoco.mj_kinematics(physics.model.ptr, physics.data.ptr)
    base = np.array([0.0, 0.0, UR5_RG2.base_height_m])
    for fixed, moving in zip(robot.hand_geoms, scene.robot.hand_geoms, strict=True):
        np.testing.assert_allclose(
            physics.bind(fixed).xpos + base, scene.physics.bind(moving).xpos, atol=1e-9
        )


def test_hand_meets_the_belt(scene):
    low = np.add(GRASP_Q_RAD, [0, 0.25, 0, -0.25, 0, 0])
    scene.robot.set_configuration(scene.physics, low, RG2.stroke_m)
    scene.physics.forward()
    assert any("conveyor/belt" in pair for pair in scene.contacts)


def test_servo_follows_a_sweep_without_lag(scene):
    q0, speed = np.array(UR5_RG2.home_q_rad), np.array([1.5, 0.5, -0.5, 0.5, 0.0, -1.5])
    ramp_s = 0.15
    for k in range(84):
        middle_s = CONTROL_STEP_S * (k + 0.5)
        factor = min(1.0, middle_s / ramp_s)
        ramped_s = 0.5 * factor * min(middle_s, ramp_s) + max(0.0, middle_s - ramp_s)
        scene.robot.command_arm(scene.physics, q0 + ramped_s * speed, factor * speed)
        scene.physics.step(4)
    reached = q0 + (84 * CONTROL_STEP_S - 0.5 * ramp_s) * speed
    # Without feed-forward the lag would be 0.05 s times the speed, 75 mrad.
    np.testing.assert_allclose(scene.robot.q(scene.physics), reached, atol=4e-3)
    np.testing.assert_allclose(scene.robot.qd(scene.physics), speed, atol=0.1)


@pytest.fixture
def grasp(scene):
    """The hand closed on the box where it stands, lying along the belt."""
    with scene.physics.reset_context():
        scene.robot.set_configuration(scene.physics, GRASP_Q_RAD, RG2.stroke_m)
        scene.place_box(0.50, -0.30, np.pi / 2)
    scene.close_fingers()
    return scene


def box_in_hand(scene) -> np.ndarray:
    """(3,) centre of the box in the tcp frame [m]."""
    tcp = scene.physics.bind(scene.robot.tcp_site)
    return tcp.xmat.reshape(3, 3).T @ (scene.box_joint.qpos[:3] - tcp.xpos)


def test_each_finger_squeezes_with_the_rated_force(grasp):
    np.testing.assert_allclose(grasp.finger_forces(), RG2.force_n, rtol=0.01)
    assert grasp.robot.width_m(grasp.physics) == pytest.approx(0.080, abs=5e-4)


def test_grip_holds_the_box_through_lift_and_shake(grasp):
    before, q = box_in_hand(grasp), GRASP_Q_RAD.copy()
    rate_radps = 2 * np.pi * 3.0
    for k in range(360):
        time_s = k * CONTROL_STEP_S
        lift = np.clip(time_s, 0.0, 1.0)
        shake = 0.038 * np.sin(rate_radps * (time_s - 1.0)) if time_s > 1.0 else 0.0
        q[:] = np.add(GRASP_Q_RAD, [shake, -0.4 * lift, 0.0, 0.4 * lift, 0.0, 0.0])
        grasp.robot.command_arm(grasp.physics, q, np.zeros(6))
        grasp.physics.step(4)
    assert grasp.box_joint.qpos[2] > 0.20
    assert np.linalg.norm(box_in_hand(grasp) - before) < 0.003
    touching = {name for pair in grasp.contacts for name in pair}
    assert touching == {"box/body", "ur5/rg2/right_pad", "ur5/rg2/left_pad"}


def test_held_box_does_not_creep(grasp):
    q = np.add(GRASP_Q_RAD, [0, -0.4, 0, 0.4, 0, 0])
    for k in range(120):
        blend = min(1.0, k / 90)
        command = GRASP_Q_RAD + blend * (q - GRASP_Q_RAD)
        grasp.robot.command_arm(grasp.physics, command, np.zeros(6))
        grasp.physics.step(4)
    before = box_in_hand(grasp)
    grasp.step(2.0)
    assert np.linalg.norm(box_in_hand(grasp) - before) / 2.0 < 1e-4  # 0.1 mm/s


def test_fingers_move_together_and_centre_the_box(scene):
    with scene.physics.reset_context():
        scene.robot.set_configuration(scene.physics, GRASP_Q_RAD, RG2.stroke_m)
        scene.place_box(0.51, -0.30, np.pi / 2)
    scene.close_fingers()
    assert abs(box_in_hand(scene)[0]) < 5e-4
    right, left = scene.physics.bind(scene.robot.finger_joints).qpos
    assert right == pytest.approx(left, abs=5e-4)


def test_empty_hand_closes_and_opens_in_time(scene):
    scene.close_fingers(RG2.stroke_m / RG2.speed_mps + 0.1)
    assert scene.robot.width_m(scene.physics) == pytest.approx(0.0, abs=5e-4)
    scene.robot.command_width(scene.physics, RG2.stroke_m)
    scene.step(0.5)
    assert scene.robot.width_m(scene.physics) == pytest.approx(RG2.stroke_m, abs=5e-4)


def test_commands_do_not_force_a_recomputation(scene):
    scene.robot.command_arm(scene.physics, UR5_RG2.home_q_rad, np.zeros(6))
    scene.robot.command_width(scene.physics, 0.05)
    scene.conveyor.set_speed(scene.physics, 0.1)
    assert not scene.physics.is_dirty


def test_opening_command_is_clipped_to_the_stroke(scene):
    for command, expected in ((1.0, 0.5 * RG2.stroke_m), (-1.0, 0.0)):
        scene.robot.command_width(scene.physics, command)
        assert scene.physics.bind(scene.robot.gripper_actuator).ctrl == pytest.approx(expected)
