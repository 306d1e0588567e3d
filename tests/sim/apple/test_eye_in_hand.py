"""The camera in the arm's hand: kinematics against the simulator, and where the arm can go."""

import numpy as np
import pytest

from sim.apple.eye_in_hand import HOME_Q_RAD, EyeInHand, PoseNoise, camera_pose
from sim.apple.world import HAND_CAMERA
from sim.geometry import look_at


@pytest.fixture(scope="module")
def scene(make):
    with make["orchard"](make["placed"]()) as orchard:
        yield orchard


def test_the_pose_from_kinematics_is_the_simulators(scene):
    rng = np.random.default_rng(0)
    for _ in range(20):
        q = rng.uniform(-2.0, 2.0, 6)
        scene.set_arm(q)
        assert scene.camera_pose(HAND_CAMERA) == pytest.approx(camera_pose(q), abs=1e-9)


def test_at_home_the_camera_is_level_and_looks_along_x():
    T = camera_pose(np.array(HOME_Q_RAD))
    assert T[:3, 2] == pytest.approx([1.0, 0.0, 0.0], abs=1e-3)
    assert T[:3, 1] == pytest.approx([0.0, 0.0, -1.0], abs=1e-3)


def test_the_arm_reaches_the_views_of_an_approach(scene, make):
    arm = EyeInHand(scene.model)
    for range_m, turn in ((0.6, -0.4), (0.4, 0.0), (0.22, 0.4)):
        T = make["view"](range_m, turn)
        assert arm.reach(T)
        reached = camera_pose(arm.q_rad)
        assert reached[:3, 3] == pytest.approx(T[:3, 3], abs=1.1e-3)
        assert reached[:3, :3] == pytest.approx(T[:3, :3], abs=3e-3)


def test_a_pose_out_of_reach_leaves_the_arm_where_it_was(scene):
    arm = EyeInHand(scene.model)
    before = arm.q_rad
    assert not arm.reach(look_at(np.array([1.6, 0.0, 0.3]), np.array([2.0, 0.0, 0.3])))
    assert np.array_equal(arm.q_rad, before)


def test_the_camera_stays_clear_of_the_fruit(scene, make):
    arm = EyeInHand(scene.model)
    assert not arm.reach(make["view"](0.01))


def test_the_steps_of_a_drive_keep_to_the_joint_speeds(scene, make):
    arm, steps = EyeInHand(scene.model), []
    assert arm.reach(make["view"](0.45, 0.3), steps.append)
    speeds = np.abs(np.diff(np.array(steps), axis=0)) * 120.0
    assert len(steps) > 10 and speeds.max() < 1.01


def test_the_noise_of_a_pose_has_the_declared_deviations():
    noise, rng = PoseNoise(rotation_rad=0.01, position_m=0.002), np.random.default_rng(0)
    wrong = np.array([noise.disturbed(np.eye(4), rng) for _ in range(3000)])
    turns = np.stack([wrong[:, 2, 1], wrong[:, 0, 2], wrong[:, 1, 0]], axis=1)
    assert turns.std(axis=0) == pytest.approx([0.01] * 3, rel=0.06)
    assert wrong[:, :3, 3].std(axis=0) == pytest.approx([0.002] * 3, rel=0.06)
    assert wrong[:, :3, :3] @ np.swapaxes(wrong[:, :3, :3], 1, 2) == pytest.approx(
        np.tile(np.eye(3), (3000, 1, 1)), abs=1e-9
    )


def test_no_noise_leaves_the_pose_as_it_is():
    T = camera_pose(np.array(HOME_Q_RAD))
    none = PoseNoise(rotation_rad=0.0)
    assert none.disturbed(T, np.random.default_rng(0)) == pytest.approx(T, abs=1e-12)


def test_a_negative_noise_is_refused():
    with pytest.raises(ValueError, match="rotation_rad must be 0 or greater, got -1"):
        PoseNoise(rotation_rad=-1)
