"""MuJoCo's interactive viewer on the scene of a trial."""

# MuJoCo ships no types.
# pyright: reportUnknownMemberType=false

from __future__ import annotations

from typing import Any

import mujoco.viewer

from experiments.belt.config import TrialConfig
from experiments.seeding import Stream, generator, random_state
from sim.belt import environment
from sim.belt.scenario import ScenarioRange
from sim.belt.task_config import Episode, TaskConfig


def show(config: TrialConfig) -> None:
    """Opens a window and returns when it is closed; belt and box move, the arm holds still."""
    task = TaskConfig(
        embodiment=config.embodiment,
        object=config.object,
        camera=config.camera,
        condition=config.condition,
        has_camera=False,
    )
    world: Any = environment.load(task, random_state(config.seed, Stream.SCENE))
    scenario = ScenarioRange().draw(
        config.motion, config.speed_mps, generator(config.seed, Stream.SCENE)
    )
    world.task.next_episode = Episode(scenario, generator(config.seed, Stream.SENSOR))
    world.reset()
    physics = world.physics
    mujoco.viewer.launch(physics.model.ptr, physics.data.ptr)
