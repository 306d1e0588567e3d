"""The compiled world of a trial, kept from trial to trial, and the truth about its object."""

import atexit
import functools
import weakref
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from experiments.belt.config import TrialConfig
from experiments.belt.teaching import reference_template
from experiments.seeding import Stream, generator
from sim.arm.embodiments import get_embodiment
from sim.arm.servo import Servo
from sim.belt.environment import load, make_servo
from sim.belt.scenario import ScenarioRange
from sim.belt.task import ConveyorGrasp
from sim.belt.task_config import Episode, TaskConfig
from tracker.affine.template import Template


@dataclass(frozen=True, eq=False)
class Truth:
    """The target as the simulator knows it."""

    time_s: float
    position_m: np.ndarray
    """(3,) centre of the top face in the world."""
    yaw_rad: float
    velocity_mps: np.ndarray
    """(3,) in the world."""
    yaw_rate_radps: float


@dataclass(frozen=True, eq=False)
class Cell:
    """A compiled world and a servo for its arm; kept from trial to trial of the same cell."""

    environment: Any
    """A `composer.Environment`; dm_control comes without types."""
    servo: Servo

    @property
    def task(self) -> ConveyorGrasp:
        """The task with its ground truth."""
        return self.environment.task

    _templates: dict[tuple[int, int, bool], Template] = field(
        default_factory=dict[tuple[int, int, bool], Template]
    )
    """By all of the condition that shows in a picture taken in normal light."""

    @property
    def template(self) -> Template:
        """The object's reference picture; taking it disturbs the world, so before a reset."""
        condition = self.task.condition
        key = condition.width_px, condition.height_px, condition.shadows
        if key not in self._templates:
            self._templates[key] = reference_template(self.task, self.environment.physics)
        return self._templates[key]

    def read_truth(self) -> Truth:
        """The target as the simulator knows it: for scoring and for the oracle arms alone."""
        physics = self.environment.physics
        T = self.task.referee.object_pose(physics)
        linear, angular = self.task.prop.get_velocity(physics)
        top = T[:3, 3] + 0.5 * self.task.prop.spec.size_m[2] * T[:3, 2]
        return Truth(
            time_s=float(physics.data.time),
            position_m=top,
            yaw_rad=float(np.arctan2(T[1, 0], T[0, 0])),
            velocity_mps=np.array(linear),
            yaw_rate_radps=float(angular[2]),
        )


def make_cell(config: TrialConfig, *, has_camera: bool) -> Cell:
    """The world that `config` asks for."""
    task = TaskConfig.of(config, has_camera=has_camera, observes_camera=False)
    cell = _compiled(task.as_compiled)
    cell.task.configure(task)
    return cell


def make_episode(config: TrialConfig) -> Episode:
    """What the seed decides of a trial's world; the same for every tracker."""
    scene_rng = generator(config.seed, Stream.SCENE)
    scenario = ScenarioRange().draw(config.motion, config.speed_mps, scene_rng)
    return Episode(scenario, generator(config.seed, Stream.SENSOR))


@functools.lru_cache(maxsize=8)
def _compiled(task: TaskConfig) -> Cell:
    """Compiling takes longer than a trial's first second: a sweep reuses its last cells."""
    cell = Cell(load(task), make_servo(get_embodiment(task.embodiment), task.carrier))
    # A finalizer's own turn at exit may come after EGL's end; registered now, its turn is before.
    release = weakref.finalize(cell, cell.task.close)
    release.atexit = False
    atexit.register(release)
    return cell
