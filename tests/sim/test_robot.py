import mujoco
import numpy as np
import pytest
from dm_control import mjcf

from sim.arena import BASE_HEIGHT_M, PHYSICS_STEP_S
from sim.robot import (
    FINGER_FORCE_N,
    FINGER_SPEED_MPS,
    HOME_Q_RAD,
    JOINT_NAMES,
    STROKE_M,
    Robot,
    dh_forward,
)

CONTROL_STEP_S = 4 * PHYSICS_STEP_S

GRASP_Q_RAD = np.array([-0.728721, -1.062806, 1.869447, -2.377437, -1.570796, -0.728721])
"""Hand down, tcp at (0.50, -0.30, 0.045) in the world, closing along x."""

# Published values, re-typed here so that a slip in the model file shows. [URDescription]
MASS_KG = (3.7, 8.393, 2.33, 1.219, 1.219, 0.1879)
COM_M = (
    (0.0, -0.00193, -0.02561),
    (-0.2125, 0.0, 0.11336),
    (-0.24225, 0.0, 0.0265),
    (0.0, -0.01634, -0.0018),
    (0.0, 0.01634, -0.0018),
    (0.0, 0.0, -0.001159),
)
INERTIA_KGM2 = (
    (0.0149724, 0.0149724, 0.0104063),
    (0.1338858, 0.1338858, 0.0151074),
    (0.0312168, 0.0312168, 0.004095),
    (0.0020139, 0.0020139, 0.0021942),
    (0.0018310, 0.0018310, 0.0021942),
    (8.0625e-5, 8.0625e-5, 1.3212e-4),
)
LINKS = ("shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3")
TORQUE_NM = (150, 150, 150, 28, 28, 28)


@pytest.fixture(scope="module")
def arm():
    robot = Robot()
    return robot, mjcf.Physics.from_mjcf_model(robot.mjcf_model)


def test_flange_follows_the_published_dh_chain(arm):
    robot, physics = arm
    rng = np.random.default_rng(0)
    for _ in range(200):
        q = rng.uniform(-np.pi, np.pi, 6)
        robot.set_configuration(physics, q, STROKE_M)
        mujoco.mj_kinematics(physics.model.ptr, physics.data.ptr)
        flange = physics.bind(robot.flange_site)
        T = dh_forward(q)
        np.testing.assert_allclose(flange.xpos, T[:3, 3], atol=1e-9)
        np.testing.assert_allclose(flange.xmat.reshape(3, 3), T[:3, :3], atol=1e-9)


def test_links_have_the_published_masses(arm):
    robot, physics = arm
    bodies = [robot.mjcf_model.find("body", name) for name in LINKS]
    bound = physics.bind(bodies)
    np.testing.assert_allclose(bound.mass, MASS_KG)
    np.testing.assert_allclose(bound.ipos, COM_M, atol=1e-12)
    np.testing.assert_allclose(
        np.sort(bound.inertia, axis=1), np.sort(np.array(INERTIA_KGM2), axis=1), rtol=1e-9
    )


def test_inertia_of_the_tubes_is_small_about_the_tube(arm):
    robot, physics = arm
    for name in ("upper_arm", "forearm"):
        body = physics.bind(robot.mjcf_model.find("body", name))
        R = np.empty(9)
        mujoco.mju_quat2Mat(R, body.iquat)
        R = R.reshape(3, 3)
        about_tube = (R @ np.diag(body.inertia) @ R.T)[0, 0]
        assert about_tube == pytest.approx(min(body.inertia), rel=1e-6)


def test_limits_are_the_published_ones(arm):
    robot, physics = arm
    joints = physics.bind(robot.arm_joints)
    upper = np.full(6, 2 * np.pi)
    upper[2] = np.pi
    np.testing.assert_allclose(joints.range, np.column_stack([-upper, upper]))
    servos = physics.bind(robot.arm_actuators)
    np.testing.assert_array_equal(servos.forcerange[:, 1], TORQUE_NM)
    np.testing.assert_array_equal(servos.forcerange[:, 0], np.negative(TORQUE_NM))
    assert tuple(joint.name for joint in robot.arm_joints) == JOINT_NAMES


def test_home_points_the_hand_down_upstream(scene):
    tcp = scene.physics.bind(scene.robot.tcp_site)
    np.testing.assert_allclose(tcp.xpos, [0.50, -0.55, 0.25], atol=1e-5)
    np.testing.assert_allclose(tcp.xmat.reshape(3, 3), np.diag([1.0, -1.0, -1.0]), atol=1e-5)
    assert abs(HOME_Q_RAD[5]) + np.pi / 2 < np.pi  # either way round by a quarter turn
    assert HOME_Q_RAD[2] > 0  # elbow up


def test_tcp_lies_between_the_pads(scene):
    tcp = scene.physics.bind(scene.robot.tcp_site)
    pads = scene.physics.bind(scene.robot.pad_geoms).xpos
    np.testing.assert_allclose(pads.mean(axis=0), tcp.xpos, atol=1e-9)
    closing_axis = pads[0] - pads[1]
    closing_axis /= np.linalg.norm(closing_axis)
    np.testing.assert_allclose(closing_axis, tcp.xmat.reshape(3, 3)[:, 0], atol=1e-9)


def test_fingertips_clear_the_belt_at_grasp_height(scene):
    scene.robot.set_configuration(scene.physics, GRASP_Q_RAD, STROKE_M)
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
    physics.bind(robot.arm_joints).qpos = HOME_Q_RAD
    mujoco.mj_kinematics(physics.model.ptr, physics.data.ptr)
    base = np.array([0.0, 0.0, BASE_HEIGHT_M])
    for fixed, moving in zip(robot.hand_geoms, scene.robot.hand_geoms, strict=True):
        np.testing.assert_allclose(
            physics.bind(fixed).xpos + base, scene.physics.bind(moving).xpos, atol=1e-9
        )


def test_arm_holds_still_without_touching_itself(scene):
    rng = np.random.default_rng(1)
    for _ in range(20):
        q = np.array(HOME_Q_RAD) + rng.uniform(-1, 1, 6) * [0.8, 0.2, 0.2, 0.2, 0.1, 1.5]
        with scene.physics.reset_context():
            scene.robot.set_configuration(scene.physics, q, STROKE_M)
        scene.step(0.1)
        assert not [pair for pair in scene.contacts if "ur5/" in pair[0] + pair[1]]
        np.testing.assert_allclose(scene.robot.q(scene.physics), q, atol=1e-4)


def test_hand_meets_the_belt(scene):
    low = np.add(GRASP_Q_RAD, [0, 0.25, 0, -0.25, 0, 0])
    scene.robot.set_configuration(scene.physics, low, STROKE_M)
    scene.physics.forward()
    assert any("conveyor/belt" in pair for pair in scene.contacts)


def test_servo_follows_a_sweep_without_lag(scene):
    q0, speed = np.array(HOME_Q_RAD), np.array([1.5, 0.5, -0.5, 0.5, 0.0, -1.5])
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


def close_fingers(scene, duration_s: float = 0.6) -> None:
    """Ramps the opening to zero as the real gripper would."""
    width = scene.robot.width_m(scene.physics)
    for _ in range(round(duration_s / CONTROL_STEP_S)):
        width = max(0.0, width - FINGER_SPEED_MPS * CONTROL_STEP_S)
        scene.robot.command_width(scene.physics, width)
        scene.physics.step(4)


def finger_forces(scene) -> list[float]:
    """Normal force [N] of the right and the left pad on the box."""
    model, data = scene.physics.model, scene.physics.data
    totals = []
    for pad in scene.robot.pad_geoms:
        total, wrench = 0.0, np.empty(6)
        for index, contact in enumerate(data.contact):
            names = {model.id2name(g, "geom") for g in (contact.geom1, contact.geom2)}
            if pad.full_identifier in names and "box/body" in names:
                mujoco.mj_contactForce(model.ptr, data.ptr, index, wrench)
                total += wrench[0]
        totals.append(total)
    return totals


@pytest.fixture
def grasp(scene):
    """The hand closed on the box where it stands, lying along the belt."""
    with scene.physics.reset_context():
        scene.robot.set_configuration(scene.physics, GRASP_Q_RAD, STROKE_M)
        scene.place_box(0.50, -0.30, np.pi / 2)
    close_fingers(scene)
    return scene


def box_in_hand(scene) -> np.ndarray:
    """(3,) centre of the box in the tcp frame [m]."""
    tcp = scene.physics.bind(scene.robot.tcp_site)
    return tcp.xmat.reshape(3, 3).T @ (scene.box_joint.qpos[:3] - tcp.xpos)


def test_each_finger_squeezes_with_the_rated_force(grasp):
    np.testing.assert_allclose(finger_forces(grasp), FINGER_FORCE_N, rtol=0.01)
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
        scene.robot.set_configuration(scene.physics, GRASP_Q_RAD, STROKE_M)
        scene.place_box(0.51, -0.30, np.pi / 2)
    close_fingers(scene)
    assert abs(box_in_hand(scene)[0]) < 5e-4
    right, left = scene.physics.bind(scene.robot.finger_joints).qpos
    assert right == pytest.approx(left, abs=5e-4)


def test_empty_hand_closes_and_opens_in_time(scene):
    close_fingers(scene, STROKE_M / FINGER_SPEED_MPS + 0.1)
    assert scene.robot.width_m(scene.physics) == pytest.approx(0.0, abs=5e-4)
    scene.robot.command_width(scene.physics, STROKE_M)
    scene.step(0.5)
    assert scene.robot.width_m(scene.physics) == pytest.approx(STROKE_M, abs=5e-4)


def test_commands_do_not_force_a_recomputation(scene):
    scene.robot.command_arm(scene.physics, HOME_Q_RAD, np.zeros(6))
    scene.robot.command_width(scene.physics, 0.05)
    scene.conveyor.set_speed(scene.physics, 0.1)
    assert not scene.physics.is_dirty


def test_opening_command_is_clipped_to_the_stroke(scene):
    for command, expected in ((1.0, 0.5 * STROKE_M), (-1.0, 0.0)):
        scene.robot.command_width(scene.physics, command)
        assert scene.physics.bind(scene.robot.gripper_actuator).ctrl == pytest.approx(expected)
