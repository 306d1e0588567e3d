"""What a trial costs and where: whole trial, camera image, physics step, IK solve.

`make bench` prints the split of a trial and the table.
"""

from collections.abc import Iterator

import cv2
import numpy as np
import pytest
from dm_control import composer

from experiments.belt.cell import make_cell
from experiments.belt.config import TrialConfig
from experiments.belt.loop import Loop
from experiments.belt.perception import CONTROL_ARMS
from sim.arm.embodiments import UR5_RG2
from sim.arm.motion import top_down_pose
from sim.belt.environment import load, make_servo
from sim.belt.task_config import TaskConfig

ROUNDS = 5


@pytest.fixture(autouse=True)
def one_thread() -> None:
    cv2.setNumThreads(1)


@pytest.fixture(scope="module")
def environment() -> Iterator[composer.Environment]:
    environment = load(TaskConfig(), random_state=0)
    environment.reset()
    yield environment
    environment.task.close()


@pytest.mark.parametrize("tracker", ["igpf", "oracle"])
def test_trial(benchmark, tracker):
    """Prints the split, and how much faster than real time the trial is on one core.

    A trial is deterministic, so control step k does the same work in every round: the least of its
    times is its cost. The pauses of a shared machine hit other steps in each round and drop out.
    """
    config = TrialConfig(tracker=tracker, speed_mps=0.25, seed=0)
    cell = make_cell(config, has_camera=tracker not in CONTROL_ARMS)
    rounds = []

    def run():
        loop, steps = Loop(config, cell), []
        while loop.is_running:
            before = loop.spent_s.copy()
            loop.step()
            steps.append([loop.spent_s[part] - before[part] for part in before])
        rounds.append(np.array(steps))
        return loop

    loop = benchmark.pedantic(run, rounds=ROUNDS, warmup_rounds=1)
    split = dict(zip(loop.spent_s, np.min(rounds[1:], axis=0).sum(axis=0), strict=True))
    factor = loop.time_s / sum(split.values())
    benchmark.extra_info |= {f"{part}_s": seconds for part, seconds in split.items()}
    benchmark.extra_info |= {"simulated_s": loop.time_s, "real_time_factor": factor}
    parts = ", ".join(f"{part} {seconds:.2f} s" for part, seconds in split.items())
    print(f"\n{tracker}: {loop.time_s:.2f} s simulated at {factor:.2f} x real time; {parts}")


@pytest.mark.parametrize("size_px", [(480, 640), (240, 640), (120, 120)])
def test_camera_image(benchmark, environment, size_px):
    develop = environment.task.expose(environment.physics, "sensor")
    benchmark(develop, (slice(0, size_px[0]), slice(0, size_px[1])))


def test_camera_exposure(benchmark, environment):
    benchmark(environment.task.expose, environment.physics, "sensor")


def test_physics_of_one_control_step(benchmark, environment):
    benchmark(environment.physics.step, 4)


def test_servo_step(benchmark):
    servo = make_servo()
    servo.reset(np.array(UR5_RG2.home_q_rad))
    goal = top_down_pose(np.array([0.5, 0.1, 0.2]), 0.4)
    benchmark(servo.step, goal, np.array([0.0, 0.25, 0.0, 0.0, 0.0, 0.0]))
