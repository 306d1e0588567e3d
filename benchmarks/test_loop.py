"""What a trial costs and where: whole trial, camera image, physics step, IK solve.

`make bench` prints the table. A whole trial is one core's work: compare its mean with the simulated
seconds in its `extra_info` for the real-time factor.
"""

from collections.abc import Iterator

import cv2
import numpy as np
import pytest

from experiments import trial
from experiments.config import TrialConfig
from sim.environment import Environment, load, make_servo
from sim.grasp import top_down_pose
from sim.robot import HOME_Q_RAD
from sim.task import TaskConfig


@pytest.fixture(autouse=True)
def one_thread() -> None:
    cv2.setNumThreads(1)


@pytest.fixture(scope="module")
def environment() -> Iterator[Environment]:
    environment = load(TaskConfig(), random_state=0)
    environment.reset()
    yield environment
    environment.task.close()


@pytest.mark.parametrize("tracker", ["igpf", "gpf", "pf", "oracle"])
def test_trial(benchmark, tracker):
    config = TrialConfig(tracker=tracker, speed_mps=0.25, seed=0)
    trial.run_trial(config)  # compiles the cell
    row, timings = benchmark.pedantic(trial.run_trial, (config,), rounds=3)
    mean_s = benchmark.stats.stats.mean
    benchmark.extra_info |= {
        "simulated_s": row.simulated_s,
        "real_time_factor": row.simulated_s / mean_s,
        "track_ms_per_image": timings.track_ms_per_image,
        "servo_ms_per_step": timings.servo_ms_per_step,
        "world_ms_per_step": timings.world_ms_per_step,
    }
    print(f"\n{tracker}: {row.simulated_s / mean_s:.2f} x real time; {timings}")


def test_camera_image(benchmark, environment):
    benchmark(environment.task.render, environment.physics, "sensor")


def test_physics_of_one_control_step(benchmark, environment):
    benchmark(environment.physics.step, 4)


def test_servo_step(benchmark):
    servo = make_servo()
    servo.reset(np.array(HOME_Q_RAD))
    goal = top_down_pose(np.array([0.5, 0.1, 0.2]), 0.4)
    benchmark(servo.step, goal, np.array([0.0, 0.25, 0.0, 0.0, 0.0, 0.0]))
