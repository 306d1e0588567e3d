"""MuJoCo's interactive viewer on the scene of a trial."""

import mujoco.viewer

from experiments.belt.cell import make_cell, make_episode
from experiments.belt.config import TrialConfig


def show(config: TrialConfig) -> None:
    """Opens a window and returns when it is closed; belt and box move, the arm holds still."""
    environment = make_cell(config, has_camera=False).environment
    environment.task.next_episode = make_episode(config)
    environment.reset()
    physics = environment.physics
    mujoco.viewer.launch(physics.model.ptr, physics.data.ptr)
