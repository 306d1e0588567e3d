"""The cell as an environment of Gymnasium, for agents that learn; needs the extra `beltgrasp[gym]`.

`gymnasium.make("sim.belt.gym:beltgrasp/ConveyorGrasp-v0")` imports this module and makes one.
"""

from typing import Any

import gymnasium
import numpy as np
from dm_env import specs
from gymnasium import spaces

from sim.belt.environment import load
from sim.belt.task import CONTROL_HZ
from sim.belt.task_config import Episode, TaskConfig

ID = "beltgrasp/ConveyorGrasp-v0"


class ConveyorGraspEnv(gymnasium.Env):
    """`sim.belt.environment.load` behind Gymnasium's interface: same actions, images and reward.

    An episode terminates when the object is held, fallen or gone, and is truncated after 30 s of
    simulated time. `info["is_success"]` is the referee's verdict.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": CONTROL_HZ}  # noqa: RUF012

    def __init__(self, render_mode: str | None = None, **settings: Any) -> None:
        """`settings` are fields of `TaskConfig`, such as `condition="dark-2"`."""
        config = TaskConfig(**settings)
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"render_mode must be None or 'rgb_array', got {render_mode!r}")
        if render_mode is not None and not config.has_camera:
            raise ValueError("render_mode must be None where has_camera is False")
        self.render_mode = render_mode
        self._environment = load(config, random_state=0)
        self.action_space = _space(self._environment.action_spec())
        specifications: dict[str, Any] = self._environment.observation_spec()
        self._spaces: dict[str, spaces.Space[Any]] = {
            name: _space(spec) for name, spec in sorted(specifications.items())
        }
        self.observation_space = spaces.Dict(self._spaces)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
        """Begins the next world; the same seed gives the same one."""
        super().reset(seed=seed)
        task = self._environment.task
        scene_rng, sensor_rng = self.np_random.spawn(2)
        config = task.config
        scenario = config.scenarios.draw(config.motion, config.speed_mps, scene_rng)
        task.next_episode = Episode(scenario, sensor_rng)
        return self._observed(self._environment.reset().observation), self._info()

    def step(
        self, action: np.ndarray
    ) -> tuple[dict[str, np.ndarray], float, bool, bool, dict[str, Any]]:
        """One control step, a 120th of a second."""
        timestep = self._environment.step(action)
        is_over = self._environment.task.should_terminate_episode(self._environment.physics)
        is_cut = bool(timestep.last()) and not is_over
        seen = self._observed(timestep.observation)
        return seen, float(timestep.reward), is_over, is_cut, self._info()

    def render(self) -> np.ndarray | None:
        """(h, w, 3) uint8 view of the whole cell, where the render mode is `rgb_array`."""
        if self.render_mode is None:
            return None
        task = self._environment.task
        return task.render(self._environment.physics, "studio")[0].copy()

    def close(self) -> None:
        """Frees the renderer and the physics."""
        self._environment.task.close()
        self._environment.close()

    def _observed(self, observation: dict[str, Any]) -> dict[str, np.ndarray]:
        """Copies, of the type that the space states: steps share an image."""
        return {
            name: np.array(observation[name], space.dtype) for name, space in self._spaces.items()
        }

    def _info(self) -> dict[str, Any]:
        return {"is_success": self._environment.task.referee.record.is_success}


def _space(spec: specs.Array) -> spaces.Box:
    """The box of a dm_env spec; without bounds, all that its type holds."""
    if isinstance(spec, specs.BoundedArray):
        low, high = (np.broadcast_to(b, spec.shape) for b in (spec.minimum, spec.maximum))
        return spaces.Box(low.astype(spec.dtype), high.astype(spec.dtype), dtype=spec.dtype.type)
    if np.issubdtype(spec.dtype, np.integer):
        limits = np.iinfo(spec.dtype)
        return spaces.Box(limits.min, limits.max, spec.shape, spec.dtype.type)
    return spaces.Box(-np.inf, np.inf, spec.shape, spec.dtype.type)


gymnasium.register(ID, entry_point="sim.belt.gym:ConveyorGraspEnv")
