"""Gymnasium's own check, worlds by seed, and how an episode ends."""

import re
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import sim.belt.gym
from sim.belt.task import CONTROL_HZ

NAME = f"sim.belt.gym:{sim.belt.gym.ID}"


@pytest.fixture(scope="module")
def environment():
    settings = {"condition": "resolution-3", "delay_s": 0.0, "speed_mps": 1.0}
    environment = gymnasium.make(NAME, render_mode="rgb_array", **settings)
    yield environment
    environment.close()


@pytest.mark.filterwarnings("ignore::UserWarning")  # that a Box has no bounds or is not symmetric
def test_environment_passes_gymnasium_s_check(environment):
    check_env(environment.unwrapped)


def test_worlds_come_from_the_seed(environment):
    pictures = []
    for seed in (3, 3, 4):
        environment.reset(seed=seed)
        pictures.append(environment.render())
        assert pictures[-1].shape == (60, 80, 3)
    assert np.array_equal(pictures[0], pictures[1])
    assert not np.array_equal(pictures[0], pictures[2])


def test_truth_is_not_observed(environment):
    names = {name.split("/")[0] for name in environment.observation_space}
    assert names == {"camera", "robot"}


def test_episode_terminates_where_the_object_is_gone(environment):
    seen, info = environment.reset(seed=0)
    action = np.array([*seen["robot/q_rad"], *np.zeros(6), 0.11])
    for _ in range(3 * CONTROL_HZ):
        _, reward, terminated, truncated, info = environment.step(action)
        if terminated or truncated:
            break
    assert terminated and not truncated and reward == 0.0 and not info["is_success"]


def test_episode_is_cut_at_the_time_limit(monkeypatch):
    monkeypatch.setattr("sim.belt.environment.TIME_LIMIT_S", 0.25)
    environment = gymnasium.make(NAME, has_camera=False, speed_mps=0.0)
    seen, _ = environment.reset(seed=0)
    action = np.array([*seen["robot/q_rad"], *np.zeros(6), 0.11])
    ends = []
    while not any(ends):
        ends = environment.step(action)[2:4]
    time_s = environment.unwrapped._environment.physics.time()
    environment.close()
    assert ends == (False, True)
    assert time_s == pytest.approx(0.25, abs=0.02)


def test_example_of_the_guide_runs():
    guide = (Path(__file__).resolve().parents[3] / "docs" / "guide.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"```python\n(import gymnasium.*?)```", guide, re.DOTALL)
    names = {}
    exec(example, names)
    assert names["environment"].observation_space.contains(names["observation"])


def test_what_cannot_be_rendered_is_refused():
    with pytest.raises(ValueError, match="render_mode must be None or 'rgb_array', got 'human'"):
        sim.belt.gym.ConveyorGraspEnv(render_mode="human")
    with pytest.raises(ValueError, match="render_mode must be None where has_camera is False"):
        sim.belt.gym.ConveyorGraspEnv(render_mode="rgb_array", has_camera=False)
    with pytest.raises(ValueError, match="condition must be normal"):
        sim.belt.gym.ConveyorGraspEnv(condition="foggy")
