"""The servo: convergence, limits, no lag behind a moving goal, no exception out of reach."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.arm.embodiments import UR5_RG2
from sim.arm.motion import top_down_pose
from sim.arm.servo import Servo, ServoConfig, braking_speed
from sim.belt.environment import make_servo

DT = 1.0 / ServoConfig().rate_hz
NO_TWIST = np.zeros(6)


@pytest.fixture(scope="module")
def shared_servo() -> Servo:
    return make_servo()


@pytest.fixture
def servo(shared_servo) -> Servo:
    shared_servo.reset(np.array(UR5_RG2.home_q_rad))
    return shared_servo


def drive(servo: Servo, goal: np.ndarray, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Joint velocities (steps, 6) and tool positions (steps, 3) on the way to a still goal."""
    velocities, positions = [], []
    for _ in range(steps):
        servo.step(goal, NO_TWIST)
        velocities.append(servo.qd)
        positions.append(servo.T_world_tcp[:3, 3])
    return np.array(velocities), np.array(positions)


def test_reaches_a_still_goal_without_overshoot(servo):
    goal = top_down_pose(np.array([0.55, 0.10, 0.20]), 0.6)
    start = servo.T_world_tcp[:3, 3]
    _, positions = drive(servo, goal, 240)
    assert np.linalg.norm(positions[-1] - goal[:3, 3]) < 1e-4
    way = goal[:3, 3] - start
    along = (positions - start) @ way / (way @ way)
    assert along.max() < 1.01
    assert np.abs(servo.T_world_tcp[:3, :3] - goal[:3, :3]).max() < 1e-3


def test_velocity_and_acceleration_stay_within_limits(servo):
    config = ServoConfig()
    velocities, _ = drive(servo, top_down_pose(np.array([0.55, 0.55, 0.30]), -1.2), 240)
    assert (np.abs(velocities) <= np.array(UR5_RG2.arm.joint_speed_radps) + 1e-6).all()
    accelerations = np.diff(velocities, axis=0, prepend=np.zeros((1, 6))) / DT
    assert np.abs(accelerations).max() <= config.joint_acceleration_radps2 * (1 + 1e-3)


def test_follows_a_moving_goal_without_lag(servo):
    velocity = np.array([0.0, 0.5, 0.0])
    twist = np.concatenate([velocity, np.zeros(3)])
    position = np.array([0.5, -0.55, 0.2])
    lags = []
    for step in range(160):
        servo.step(top_down_pose(position, 0.0), twist)
        position = position + velocity * DT
        if step > 80:
            lags.append(np.linalg.norm(position - servo.T_world_tcp[:3, 3]))
    assert max(lags) < 5e-4


def test_feed_forward_sign_matters(servo):
    """A wrong sign still grasps slow boxes; here it must show."""
    twist = np.array([0.0, -0.3, 0.0, 0.0, 0.0, 0.0])
    position = np.array([0.5, -0.55, 0.2])
    for _ in range(120):
        servo.step(top_down_pose(position, 0.0), twist)
        position = position + np.array([0.0, 0.3 * DT, 0.0])
    assert np.linalg.norm(position - servo.T_world_tcp[:3, 3]) > 0.01


def test_unreachable_goal_is_no_exception(servo):
    _, positions = drive(servo, top_down_pose(np.array([0.5, 2.5, 0.2]), 0.0), 300)
    assert np.isfinite(positions).all()
    assert np.abs(servo.q).max() <= 2 * np.pi


def test_hand_is_kept_off_the_belt(servo):
    _, positions = drive(servo, top_down_pose(np.array([0.5, -0.3, -0.10]), 0.0), 240)
    fingertip_below_tcp = 0.032
    assert positions[:, 2].min() > fingertip_below_tcp


@given(st.floats(1e-6, 2.0), st.floats(5.0, 60.0), st.floats(0.5, 20.0))
def test_braking_speed_never_asks_for_more_than_the_braking(distance, gain_hz, braking):
    step = 1e-6 * distance
    here, nearer = braking_speed(np.array([distance, distance - step]), gain_hz, braking)
    deceleration = here * (here - nearer) / step  # dv/dt = v dv/dx
    assert deceleration <= braking * (1 + 1e-3)
    assert here >= nearer >= 0.0


def test_bad_configs_are_refused():
    with pytest.raises(ValueError, match="gain_hz must be a positive number, got nan"):
        ServoConfig(gain_hz=float("nan"))
    with pytest.raises(ValueError, match="braking_mps2"):
        ServoConfig(braking_mps2=-1.0)
