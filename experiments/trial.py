"""One attempt, closed loop: image -> warp -> pose -> prediction -> grasp -> servo -> world."""

from __future__ import annotations

import functools
import time
import weakref
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments import metrics
from experiments.config import TrialConfig, TrialResult, TrialTimings
from experiments.manifest import provenance
from experiments.perception import CONTROL_ARMS, NoisyOracle, Oracle, Perception, Seeing, Truth
from experiments.seeding import Stream, generator
from experiments.teaching import reference_template
from experiments.trace import ControlSample, EstimateSample, TrialTrace
from experiments.video import VideoRecorder
from sim.conveyor import ConstantSpeed
from sim.environment import Environment, load, make_servo
from sim.grasp import Grasp, GraspCommand, GraspConfig, Phase, TargetMotion, servo_error
from sim.referee import PhysicalRecord
from sim.scenario import ScenarioRange
from sim.servo import Servo
from sim.task import CONTROL_HZ, ConveyorGrasp, Episode, TaskConfig
from tracker.perception import TargetObservation, TargetTracker
from tracker.prediction import make_predictor
from tracker.rectify import OverheadView
from tracker.registry import get_tracker_config
from tracker.template import Template

HOLD_PATIENCE_S = 1.5
"""A hand that has held still this long without success holds nothing."""


def run_trial(
    config: TrialConfig, video_path: Path | None = None, *, preset: str = "trial"
) -> tuple[TrialResult, TrialTimings]:
    """Runs one attempt.

    Args:
        config: Everything that determines the attempt.
        video_path: Where to write a video of it, if anywhere.
        preset: Name of the sweep it belongs to, for the row.
    """
    cell = _make_cell(_task_config(config, needs_images=video_path is not None))
    with VideoRecorder(video_path, config) as video:
        loop = Loop(config, cell)
        while loop.is_running:
            loop.step()
            video.add(loop)
    measured = metrics.score(config, loop.trace, loop.record, loop.entered_view_s)
    shared = {name: getattr(config, name) for name in _CONFIG_COLUMNS}
    row = TrialResult(
        trial_id=config.trial_id,
        preset=preset,
        gl_renderer=cell.task.gl_renderer,
        **shared,
        **measured,
        **provenance(),
    )
    return row, loop.timings()


_CONFIG_COLUMNS = "tracker camera condition object predictor speed_mps delay_s seed".split()


@dataclass(frozen=True, eq=False)
class Cell:
    """A compiled world and a servo for its arm; kept from trial to trial of the same cell."""

    environment: Environment
    servo: Servo

    @property
    def task(self) -> ConveyorGrasp:
        """The task with its ground truth."""
        return self.environment.task

    @functools.cached_property
    def template(self) -> Template:
        """The object's reference picture; taking it disturbs the world, so before a reset."""
        return reference_template(self.task, self.environment.physics)

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


def _task_config(config: TrialConfig, needs_images: bool) -> TaskConfig:
    return TaskConfig(
        object=config.object,
        camera=config.camera,
        condition=config.condition,
        camera_rate_hz=config.camera_rate_hz,
        delay_s=config.delay_s,
        gripper_delay_s=config.gripper_delay_s,
        has_camera=needs_images or config.tracker not in CONTROL_ARMS,
    )


@functools.lru_cache(maxsize=4)
def _make_cell(config: TaskConfig) -> Cell:
    """Compiling takes longer than a trial's first second: a sweep reuses its last cells."""
    cell = Cell(load(config), make_servo())
    weakref.finalize(cell, cell.task.close)
    return cell


def make_perception(config: TrialConfig, cell: Cell) -> Perception:
    """The tracker or control arm that `config` names."""
    if config.tracker == "oracle":
        return Oracle(cell.read_truth)
    predictor = make_predictor(config.predictor)
    rng = generator(config.seed, Stream.TRACKER)
    if config.tracker == "oracle-noisy":
        return NoisyOracle(
            cell.read_truth,
            predictor,
            config.camera_rate_hz,
            config.delay_s,
            cell.task.view.T_world_camera,
            rng,
        )
    settings = get_tracker_config(config.tracker).with_particle_count(config.particle_count)
    task = cell.task
    length_m, width_m, height_m = task.prop.spec.size_m
    view = OverheadView(
        K=task.K,
        T_world_camera=task.view.T_world_camera,
        image_shape_px=(task.condition.height_px, task.condition.width_px),
        plane_z_m=height_m,
    )
    tracker = TargetTracker(settings, cell.template, (length_m, width_m), view, rng)
    return Seeing(tracker, predictor)


class Loop:
    """The closed loop of one trial, control step by control step."""

    def __init__(self, config: TrialConfig, cell: Cell) -> None:
        self.cell, self.trace = cell, TrialTrace()
        self._started = time.perf_counter()
        self._track_s = self._servo_s = self._world_s = 0.0
        scenario = ScenarioRange().draw(
            ConstantSpeed(config.speed_mps), generator(config.seed, Stream.SCENE)
        )
        self.perception = make_perception(config, cell)  # photographs before the world begins
        cell.task.next_episode = Episode(scenario, generator(config.seed, Stream.SENSOR))
        self._timestep = cell.environment.reset()
        cell.servo.reset(cell.task.robot.q(cell.environment.physics))
        self.grasp = Grasp(
            GraspConfig(), 1.0 / CONTROL_HZ, config.gripper_delay_s, cell.servo.T_world_tcp
        )
        self.command: GraspCommand | None = None
        self.image: np.ndarray | None = None
        """(h, w, 3) uint8, the image that perception has seen last; None without a camera."""
        self.has_entered_view, self.entered_view_s = False, 0.0
        self._trial_id = config.trial_id

    @property
    def is_running(self) -> bool:
        """Until the environment ends the episode, or the hand has held still in vain."""
        held_s = self.grasp.entered_s.get(Phase.HOLD)
        is_idle = held_s is not None and self.time_s > held_s + HOLD_PATIENCE_S
        return not (self._timestep.last() or is_idle)

    @property
    def time_s(self) -> float:
        """Simulated time."""
        return float(self.cell.environment.physics.data.time)

    def step(self) -> None:
        """Sees, decides, moves, and lets the world go on by one control step."""
        now, seen, servo = self.time_s, self._timestep.observation, self.cell.servo
        self.image = seen.get("camera/rgb")
        t0 = time.perf_counter()
        estimate = None if self.grasp.has_gripped else self.perception.update(seen)
        target = self.perception.predict(now)
        t1 = time.perf_counter()
        hand = servo.T_world_tcp
        self.command = self.grasp.step(
            now, target, self.perception.pose_count, hand, float(seen["robot/width_m"])
        )
        q, qd = servo.step(self.command.T_world_tcp, self.command.twist)
        t2 = time.perf_counter()
        self._remember(now, estimate, target, hand)
        self._timestep = self.cell.environment.step(np.concatenate([q, qd, [self.command.width_m]]))
        self._track_s += t1 - t0
        self._servo_s += t2 - t1
        self._world_s += time.perf_counter() - t2

    @property
    def seen(self) -> TargetObservation | None:
        """What a tracker made of it; None for the control arms, and once the hand has gripped."""
        if self.grasp.has_gripped or not isinstance(self.perception, Seeing):
            return None
        return self.perception.last

    def render_studio(self) -> np.ndarray:
        """(h, w, 3) uint8 view of the whole cell."""
        return self.cell.task.render(self.cell.environment.physics, "studio")[0]

    @property
    def record(self) -> PhysicalRecord:
        """What physics says about the attempt."""
        return self.cell.task.referee.record

    def timings(self) -> TrialTimings:
        """Wall-clock costs; rendering is part of the world."""
        steps, images = len(self.trace.control), len(self.trace.estimates)
        return TrialTimings(
            trial_id=self._trial_id,
            wall_s=time.perf_counter() - self._started,
            simulated_s=self.time_s,
            track_ms_per_image=1e3 * self._track_s / images if images else None,
            servo_ms_per_step=1e3 * self._servo_s / steps,
            world_ms_per_step=1e3 * self._world_s / steps,
        )

    def _remember(
        self,
        now: float,
        estimate: EstimateSample | None,
        target: TargetMotion | None,
        hand: np.ndarray,
    ) -> None:
        truth = self.cell.read_truth()
        if not self.has_entered_view and self.cell.task.is_in_view(self.cell.environment.physics):
            self.has_entered_view, self.entered_view_s = True, now
        error = None
        if target is not None:
            error = servo_error(target, hand, self.grasp.config.depth_m)
        self.trace.control.append(
            ControlSample(
                time_s=now,
                phase=self.grasp.phase,
                true_position_m=truth.position_m,
                true_yaw_rad=truth.yaw_rad,
                tcp_position_m=hand[:3, 3].copy(),
                servo_error=error,
                is_feasible=self.cell.servo.is_feasible,
            )
        )
        if estimate is not None:
            self.trace.estimates.append(estimate)
