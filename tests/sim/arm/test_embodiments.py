"""Every embodiment waits where it says, reaches what it must, and keeps off itself."""

import numpy as np
import pytest

from sim.arm.embodiments import EMBODIMENTS, UR3_SOFT, UR5_RG2, get_embodiment
from sim.arm.motion import top_down_pose
from sim.arm.servo import Servo
from sim.belt.carriers import BELT_CENTRE_X_M
from sim.belt.environment import make_servo
from sim.belt.scenario import ScenarioRange


@pytest.fixture(scope="module", params=list(EMBODIMENTS))
def name(request):
    return request.param


@pytest.fixture(scope="module")
def servo(name) -> Servo:
    return make_servo(EMBODIMENTS[name])


@pytest.fixture
def at_home(name, scene, soft_scene):
    return {"ur5-rg2": scene, "ur3-soft": soft_scene}[name]


def test_home_points_the_hand_down_at_the_waiting_point(name, at_home):
    embodiment = EMBODIMENTS[name]
    tcp = at_home.physics.bind(at_home.robot.tcp_site)
    np.testing.assert_allclose(tcp.xpos[0], BELT_CENTRE_X_M, atol=1e-5)
    assert abs(tcp.xpos[1] - embodiment.grasp.wait_y_m) < 0.05
    assert tcp.xpos[2] > 0.08 + embodiment.grasp.hover_m
    np.testing.assert_allclose(tcp.xmat.reshape(3, 3), np.diag([1.0, -1.0, -1.0]), atol=1e-5)
    assert abs(embodiment.home_q_rad[5]) + np.pi / 2 < np.pi  # either way round by a quarter turn
    assert embodiment.home_q_rad[2] > 0  # elbow up


def test_base_stands_where_the_embodiment_says(name, at_home):
    embodiment = EMBODIMENTS[name]
    base = at_home.physics.bind(at_home.robot.mjcf_model.find("body", "base"))
    np.testing.assert_allclose(
        base.xpos, [embodiment.base_x_m, 0.0, embodiment.base_height_m], atol=1e-12
    )


def test_nothing_touches_at_the_start_but_box_and_belt(at_home):
    at_home.step(0.05)
    assert at_home.contacts == {("box/body", "conveyor/belt")}


def test_hand_opens_as_far_as_the_gripper_can(name):
    embodiment = EMBODIMENTS[name]
    assert embodiment.grasp.open_width_m == embodiment.gripper.stroke_m


def test_arm_holds_still_without_touching_itself(name, at_home):
    rng = np.random.default_rng(1)
    home = np.array(EMBODIMENTS[name].home_q_rad)
    for _ in range(20):
        q = home + rng.uniform(-1, 1, 6) * [0.8, 0.2, 0.2, 0.2, 0.1, 1.5]
        with at_home.physics.reset_context():
            at_home.robot.set_configuration(at_home.physics, q, 0.1)
        at_home.step(0.1)
        assert not [pair for pair in at_home.contacts if "ur" in pair[0] + pair[1]]
        np.testing.assert_allclose(at_home.robot.q(at_home.physics), q, atol=1e-3)


@pytest.mark.parametrize("lane_m", ScenarioRange().offset_m)
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_outer_lanes_are_reached_from_grasp_to_lift(name, servo, lane_m, side):
    embodiment = EMBODIMENTS[name]
    reach_m = abs(embodiment.grasp.wait_y_m)
    grasp_m = 0.08 - embodiment.grasp.depth_m
    for height_m in (grasp_m, 0.08 + embodiment.grasp.hover_m, grasp_m + embodiment.grasp.lift_m):
        servo.reset(np.array(embodiment.home_q_rad))
        goal = top_down_pose(np.array([BELT_CENTRE_X_M + lane_m, side * reach_m, height_m]), 0.0)
        for _ in range(300):
            servo.step(goal, np.zeros(6))
        assert np.linalg.norm(servo.T_world_tcp[:3, 3] - goal[:3, 3]) < 1e-3


def test_wrist_of_the_ur3_has_no_end_stop():
    servo = make_servo(UR3_SOFT)
    q = np.array(UR3_SOFT.home_q_rad)
    q[5] = 3.0 * np.pi
    servo.reset(q)
    _, qd = servo.step(servo.T_world_tcp, np.array([0.0, 0.0, 0.0, 0.0, 0.0, -1.0]))
    assert servo.is_feasible and qd[5] > 0.0


def test_unknown_embodiment_lists_the_known_ones():
    assert get_embodiment("ur5-rg2") is UR5_RG2
    with pytest.raises(ValueError, match="one of ur5-rg2, ur3-soft; got 'ur4'"):
        get_embodiment("ur4")
