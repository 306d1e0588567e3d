"""The compiled world of a trial, kept from trial to trial, and the truth about its object."""

from __future__ import annotations

import atexit
import functools
import weakref
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from experiments.belt.config import TrialConfig
from experiments.belt.teaching import reference_template
from sim.arm.embodiments import get_embodiment
from sim.arm.servo import Servo
from sim.belt.environment import load, make_servo
from sim.belt.motions import MOTIONS
from sim.belt.task import ConveyorGrasp
from sim.belt.task_config import TaskConfig
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
    """A `sim.belt.environment.Environment`; dm_control comes without types."""
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
    task = TaskConfig(
        embodiment=config.embodiment,
        object=config.object,
        camera=config.camera,
        has_camera=has_camera,
        observes_camera=False,
        condition=config.condition,
        motion=config.motion,
        camera_rate_hz=config.camera_rate_hz,
        delay_s=config.delay_s,
        gripper_delay_s=config.gripper_delay_s,
    )
    cell = _compiled(task.embodiment, task.object, task.camera, task.carrier, has_camera=has_camera)
    cell.task.configure(task)
    return cell


@functools.lru_cache(maxsize=8)
def _compiled(
    embodiment: str, object_name: str, camera: str, carrier: str, *, has_camera: bool
) -> Cell:
    """Compiling takes longer than a trial's first second: a sweep reuses its last cells."""
    task = TaskConfig(
        embodiment=embodiment,
        object=object_name,
        camera=camera,
        motion=next(name for name, entry in MOTIONS.items() if entry.carrier == carrier),
        has_camera=has_camera,
    )
    cell = Cell(load(task), make_servo(get_embodiment(embodiment), carrier))
    # A finalizer's own turn at exit may come after EGL's end; registered now, its turn is before.
    release = weakref.finalize(cell, cell.task.close)
    release.atexit = False
    atexit.register(release)
    return cell
