"""The environment: dm_env contract, delays in simulated time, worlds by seed, honest physics."""

import math
from dataclasses import replace

import numpy as np
import pytest
from dm_env import StepType

from sim.arm.embodiments import RG2
from sim.belt.carriers import Pose
from sim.belt.environment import load
from sim.belt.scenario import Scenario
from sim.belt.task import CONTROL_HZ
from sim.belt.task_config import Episode, TaskConfig


@pytest.fixture(scope="module")
def environment():
    environment = load(TaskConfig(delay_s=0.05, gripper_delay_s=0.05), random_state=0)
    yield environment
    environment.task.close()


def still(environment, width_m: float = RG2.stroke_m) -> np.ndarray:
    """The action that stays in place."""
    q = environment.task.robot.q(environment.physics)
    return np.concatenate([q, np.zeros(6), [width_m]])


def begin(environment, *, speed_mps: float, y_m: float, yaw_rad: float = math.pi / 2):
    scenario = Scenario(lambda time_s: speed_mps, Pose(0.5, y_m, yaw_rad))
    environment.task.next_episode = Episode(scenario, np.random.default_rng(0))
    return environment.reset()


def test_observations_and_actions_match_their_specs(environment):
    timestep = environment.reset()
    assert timestep.step_type is StepType.FIRST
    for name, spec in environment.observation_spec().items():
        spec.validate(timestep.observation[name])
    action = still(environment)
    environment.action_spec().validate(action)
    assert environment.step(action).step_type is StepType.MID


def test_ground_truth_is_not_observed(environment):
    names = set(environment.reset().observation)
    assert names == {
        "camera/rgb",
        "camera/depth_m",
        "camera/time_s",
        "camera/count",
        "robot/q_rad",
        "robot/qd_radps",
        "robot/width_m",
    }


def test_images_arrive_late_by_the_delay_and_at_the_camera_rate(environment):
    begin(environment, speed_mps=0.2, y_m=-0.8)
    action, arrivals = still(environment), {}
    for _ in range(60):
        seen = environment.step(action).observation
        count, exposed_s = int(seen["camera/count"]), float(seen["camera/time_s"])
        now = float(environment.physics.data.time)
        if count:
            arrivals.setdefault(exposed_s, now - exposed_s)
    exposures = np.array(sorted(arrivals))
    assert np.allclose(np.diff(exposures), 1 / 30)
    ages = np.array(list(arrivals.values()))
    assert (ages >= 0.05 - 1e-9).all() and (ages <= 0.05 + 1 / CONTROL_HZ + 1e-9).all()


def test_first_image_is_no_image_until_the_delay_has_passed(environment):
    assert begin(environment, speed_mps=0.2, y_m=-0.8).observation["camera/count"] == 0


def test_fingers_start_late_and_close_at_the_gripper_s_speed(environment):
    begin(environment, speed_mps=0.0, y_m=-1.1)
    action, widths = still(environment, 0.0), []
    for _ in range(CONTROL_HZ):
        widths.append(float(environment.step(action).observation["robot/width_m"]))
    times = np.arange(1, CONTROL_HZ + 1) / CONTROL_HZ
    started = times[np.array(widths) < RG2.stroke_m - 0.001][0]
    assert 0.05 < started < 0.10
    half_way = (times > 0.3) & (times < 0.6)
    speed = -np.polyfit(times[half_way], np.array(widths)[half_way], 1)[0]
    assert speed == pytest.approx(RG2.speed_mps, rel=0.02)


def test_object_rides_at_belt_speed_and_is_gone_at_the_end(environment):
    begin(environment, speed_mps=1.0, y_m=0.5)
    action, timestep = still(environment), None
    for _ in range(CONTROL_HZ):
        timestep = environment.step(action)
        if timestep.last():
            break
    record = environment.task.referee.record
    assert timestep.last() and record.has_left and not record.is_success
    travelled = environment.task.referee.object_pose(environment.physics)[1, 3] - 0.5
    assert travelled == pytest.approx(float(environment.physics.data.time), rel=0.01)


def first_picture(environment, config: TaskConfig, seed: int) -> np.ndarray:
    before = environment.task.config
    environment.task.configure(config)
    try:
        environment.random_state.seed(seed)
        environment.reset()
        return environment.step(still(environment)).observation["camera/rgb"]
    finally:
        environment.task.configure(before)


def test_same_seed_gives_the_same_pictures(environment):
    config = TaskConfig(delay_s=0.0)
    first = first_picture(environment, config, 4)
    assert np.array_equal(first_picture(environment, config, 4), first)
    assert not np.array_equal(first_picture(environment, config, 5), first)


def test_light_scale_darkens_the_picture(environment):
    dark, normal = (
        first_picture(environment, TaskConfig(condition=condition, delay_s=0.0), 0).mean()
        for condition in ("dark-2", "normal")
    )
    assert dark < 0.4 * normal


def test_condition_and_delay_change_without_a_new_model(environment):
    fresh = load(TaskConfig(condition="resolution-2", delay_s=0.0), random_state=0)
    try:
        environment.task.configure(
            replace(environment.task.config, condition="resolution-2", delay_s=0.0)
        )
        scenario = Scenario(lambda time_s: 0.2, Pose(0.5, -0.8, 0.3))
        seen = []
        for world in (environment, fresh):
            world.task.next_episode = Episode(scenario, np.random.default_rng(5))
            world.reset()
            seen.append(world.step(still(world)).observation)
        assert seen[0]["camera/rgb"].shape == (120, 160, 3)
        assert all(np.array_equal(seen[0][name], seen[1][name]) for name in seen[1])
    finally:
        fresh.task.close()
        environment.task.configure(TaskConfig(delay_s=0.05, gripper_delay_s=0.05))


def test_another_object_camera_or_carrier_needs_a_new_model(environment):
    with pytest.raises(
        ValueError, match="camera is 'far-side' in the compiled model, got 'overhead'"
    ):
        environment.task.configure(TaskConfig(camera="overhead"))
    with pytest.raises(ValueError, match="carrier is 'belt' in the compiled model"):
        environment.task.configure(TaskConfig(motion="turntable"))


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("camera_rate_hz", 50.0, "camera_rate_hz must divide 480"),
        ("camera_rate_hz", math.nan, "camera_rate_hz must be a number from 1 to 120, got nan"),
        ("delay_s", -0.1, "delay_s must be a number from 0 to 1, got -0.1"),
        ("camera", "under", "camera must be one of far-side, kinect, overhead; got 'under'"),
        ("condition", "foggy", "condition must be normal, or NAME-LEVEL"),
        ("motion", "zigzag", "motion must be one of constant"),
        ("speed_mps", -1.0, "speed_mps must be a number from 0 to 3, got -1.0"),
        ("embodiment", "ur7", "embodiment must be one of ur5-rg2, ur3-soft; got 'ur7'"),
        (
            "object",
            "ball",
            "object must be one of box, small-carton, plain-box, can, flask; got 'ball'",
        ),
    ],
)
def test_bad_configs_are_refused(field, value, message):
    with pytest.raises(ValueError, match=message):
        TaskConfig(**{field: value})
