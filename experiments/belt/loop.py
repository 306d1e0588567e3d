"""The closed loop: image -> warp -> pose -> prediction -> grasp -> servo -> world."""

import time
from dataclasses import replace

import numpy as np

from experiments.belt.cell import Cell, make_episode
from experiments.belt.config import TrialConfig, TrialTimings
from experiments.belt.perception import Seeing, make_perception
from experiments.belt.trace import ControlSample, EstimateSample, TrialTrace
from sim.arm.grasp import Grasp, GraspCommand, Phase
from sim.arm.motion import TargetMotion, servo_error
from sim.belt.referee import PhysicalRecord
from sim.belt.task import CONTROL_HZ
from sim.imaging.sensor import CameraImage
from tracker.belt.perception import TargetObservation

HOLD_PATIENCE_S = 1.5
"""A hand that has held still this long without success holds nothing."""


class Loop:
    """The closed loop of one trial, control step by control step."""

    def __init__(self, config: TrialConfig, cell: Cell) -> None:
        self.cell, self.trace = cell, TrialTrace()
        self._started = time.perf_counter()
        self.perception = make_perception(config, cell)  # photographs before the world begins
        cell.task.next_episode = make_episode(config)
        self._timestep = cell.environment.reset()
        cell.servo.reset(cell.task.robot.q(cell.environment.physics))
        embodiment, home = cell.task.embodiment, cell.servo.T_world_tcp
        self.grasp = Grasp(
            replace(embodiment.grasp, depth_m=cell.task.prop.spec.grasp_depth_m),
            1.0 / CONTROL_HZ,
            config.gripper_delay_s,
            home,
            base_x_m=embodiment.base_x_m,
        )
        self.command: GraspCommand | None = None
        self.image: CameraImage | None = None
        """The image that perception has seen last; None without a camera."""
        self.spent_s = {"render": 0.0, "track": 0.0, "servo": 0.0, "physics": 0.0}
        """Wall-clock time so far; physics is all of the world but the camera's images."""
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
        now, task, servo = self.time_s, self.cell.task, self.cell.servo
        if task.config.has_camera:
            self.image = task.image(self.cell.environment.physics)
        t0, rendered_s = time.perf_counter(), task.rendering_s
        estimate = None if self.grasp.has_gripped else self.perception.update(self.image)
        target = self.perception.predict(now)
        rendered_s = task.rendering_s - rendered_s
        t1 = time.perf_counter()
        hand, width_m = servo.T_world_tcp, float(self._timestep.observation["robot/width_m"])
        self.command = self.grasp.step(now, target, self.perception.pose_count, hand, width_m)
        q, qd = servo.step(self.command.T_world_tcp, self.command.twist)
        t2 = time.perf_counter()
        self._remember(now, estimate, target, hand)
        self._timestep = self.cell.environment.step(np.concatenate([q, qd, [self.command.width_m]]))
        self.spent_s["render"] += rendered_s
        self.spent_s["track"] += t1 - t0 - rendered_s
        self.spent_s["servo"] += t2 - t1
        self.spent_s["physics"] += time.perf_counter() - t2

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
        """Wall-clock costs so far."""
        steps, images = len(self.trace.control), len(self.trace.estimates)
        return TrialTimings(
            trial_id=self._trial_id,
            wall_s=time.perf_counter() - self._started,
            simulated_s=self.time_s,
            render_ms_per_image=1e3 * self.spent_s["render"] / images if images else None,
            track_ms_per_image=1e3 * self.spent_s["track"] / images if images else None,
            servo_ms_per_step=1e3 * self.spent_s["servo"] / steps,
            physics_ms_per_step=1e3 * self.spent_s["physics"] / steps,
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
        depth_m, error = self.grasp.config.depth_m, None
        if target is not None:
            error = servo_error(target, hand, depth_m)
        true_hand = self.cell.task.referee.tcp_pose(self.cell.environment.physics)
        self.trace.control.append(
            ControlSample(
                time_s=now,
                phase=self.grasp.phase,
                true_position_m=truth.position_m,
                true_yaw_rad=truth.yaw_rad,
                servo_error=error,
                true_error=servo_error(truth, true_hand, depth_m),
                is_feasible=self.cell.servo.is_feasible,
            )
        )
        if estimate is not None:
            self.trace.estimates.append(estimate)
