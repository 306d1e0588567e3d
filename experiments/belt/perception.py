"""What the arm is told about the target: a tracker's view of the images, or a control arm's.

The control arms bound what any tracker can do. `oracle` and `oracle-noisy` read the simulator's
truth; here alone truth can become what the arm is told.
"""

import functools
import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from experiments.belt.cell import Cell, Truth
from experiments.belt.config import TrialConfig
from experiments.belt.trace import EstimateSample
from experiments.seeding import Stream, generator
from sim.arm.motion import TargetMotion
from sim.imaging.sensor import CameraImage
from tracker.base import Status
from tracker.belt.backproject import TargetPose
from tracker.belt.perception import TargetObservation, TargetTracker
from tracker.belt.prediction import Predictor, TargetPrediction, make_predictor
from tracker.belt.rectify import OverheadView
from tracker.belt.registry import get_tracker_config

OBSERVED_STD_M = 0.002
OBSERVED_STD_RAD = math.radians(1.0)


@dataclass(frozen=True)
class ControlArm:
    """A stand-in for a tracker, to tell tracking failures from grasping failures."""

    description: str


CONTROL_ARMS: dict[str, ControlArm] = {
    "oracle": ControlArm("the simulator's true pose and velocity, without delay"),
    "oracle-noisy": ControlArm(
        "the true pose at camera rate and delay, with noise of 2 mm and 1 degree"
    ),
}


class Perception(Protocol):
    """What the control loop asks, once a control step."""

    pose_count: int
    """Usable poses so far."""

    def update(self, image: CameraImage | None) -> EstimateSample | None:
        """Takes in the newest image; returns an estimate where it had not been seen before."""
        ...

    def predict(self, time_s: float) -> TargetMotion | None:
        """The target at `time_s`, None while it is not known."""
        ...


def make_perception(config: TrialConfig, cell: Cell) -> Perception:
    """The tracker or control arm that `config` names."""
    if config.tracker == "oracle":
        return Oracle(cell.read_truth)
    rng = generator(config.seed, Stream.TRACKER)
    if config.tracker == "oracle-noisy":
        return NoisyOracle(
            cell.read_truth,
            make_predictor(config.predictor),
            config.camera_rate_hz,
            config.delay_s,
            cell.task.view.T_world_camera,
            rng,
        )
    settings = get_tracker_config(config.tracker).with_particle_count(config.particle_count)
    task = cell.task
    length_m, width_m, height_m = task.prop.spec.size_m
    x_range_m, y_range_m = task.carrier.face_range_m
    # Depth by time of flight has a noise of its own; it is of the size that a view takes by itself.
    view = OverheadView(
        K=task.K,
        T_world_camera=task.view.T_world_camera,
        image_shape_px=(task.condition.height_px, task.condition.width_px),
        plane_z_m=height_m,
        x_range_m=x_range_m,
        y_range_m=y_range_m,
        depth_noise_m=max(task.condition.depth_noise_std_m, OverheadView.depth_noise_m),
    )
    tracker = TargetTracker(settings, cell.template, (length_m, width_m), view, rng)
    return Seeing(tracker, functools.partial(make_predictor, config.predictor))


class Seeing:
    """A tracker on the camera's images, and a predictor over the delays."""

    def __init__(self, tracker: TargetTracker, make_predictor: Callable[[], Predictor]) -> None:
        self._tracker = tracker
        self._make_predictor = make_predictor
        self._predictor = make_predictor()
        self._image_count = 0
        self.pose_count = 0
        self.last: TargetObservation | None = None
        """What the tracker made of the newest image, for pictures."""

    def update(self, image: CameraImage | None) -> EstimateSample | None:
        """Tracks in the image if it is a new one."""
        if image is None or image.count == self._image_count:
            return None
        self._image_count = image.count
        self.last = seen = self._tracker.update(image)
        if seen.is_correction:  # the history is that of something else
            self._predictor = self._make_predictor()
        pose = seen.pose if seen.pose is not None and seen.pose.is_usable else None
        if pose is not None:
            self._predictor.update(pose)
            self.pose_count += 1
        return EstimateSample(
            time_s=image.time_s,
            position_m=None if pose is None else pose.position_m,
            yaw_rad=None if pose is None else pose.yaw_rad,
            status=seen.status,
            ess=None if seen.estimate is None else seen.estimate.ess,
            visible_fraction=None if seen.estimate is None else seen.estimate.visible_fraction,
        )

    def predict(self, time_s: float) -> TargetPrediction | None:
        """The predictor's answer."""
        return self._predictor.predict(time_s)


class Oracle:
    """The truth itself, at every control step."""

    def __init__(self, read_truth: Callable[[], Truth]) -> None:
        self._read_truth = read_truth
        self.pose_count = 0

    def update(self, image: CameraImage | None) -> EstimateSample | None:
        """Needs no image; counts a pose every control step."""
        del image
        self.pose_count += 1
        truth = self._read_truth()
        return EstimateSample(
            truth.time_s, truth.position_m, truth.yaw_rad, Status.TRACKING, None, None
        )

    def predict(self, time_s: float) -> Truth:
        """The truth of now, whatever time is asked for."""
        del time_s
        return self._read_truth()


class NoisyOracle:
    """The truth with declared noise, at the camera's rate and delay, through a predictor."""

    def __init__(
        self,
        read_truth: Callable[[], Truth],
        predictor: Predictor,
        rate_hz: float,
        delay_s: float,
        T_world_camera: np.ndarray,
        rng: np.random.Generator,
    ) -> None:
        self._read_truth = read_truth
        self._predictor = predictor
        self._T_camera_world = np.linalg.inv(T_world_camera)
        self._interval_s, self._delay_s = 1.0 / rate_hz, delay_s
        self._rng = rng
        self._in_flight: deque[TargetPose] = deque()
        self._exposures = 0
        self.pose_count = 0

    def update(self, image: CameraImage | None) -> EstimateSample | None:
        """Exposes at the camera's times; delivers what is old enough."""
        del image
        truth = self._read_truth()
        if truth.time_s >= self._exposures * self._interval_s - 1e-9:
            self._exposures += 1
            self._in_flight.append(self._observe(truth))
        if not self._in_flight or self._in_flight[0].time_s + self._delay_s > truth.time_s + 1e-9:
            return None
        pose = self._in_flight.popleft()
        self._predictor.update(pose)
        self.pose_count += 1
        return EstimateSample(
            pose.time_s, pose.position_m, pose.yaw_rad, Status.TRACKING, None, None
        )

    def predict(self, time_s: float) -> TargetPrediction | None:
        """The predictor's answer."""
        return self._predictor.predict(time_s)

    def _observe(self, truth: Truth) -> TargetPose:
        noise = self._rng.standard_normal(4)
        variances = [OBSERVED_STD_M**2] * 3 + [OBSERVED_STD_RAD**2]
        position_m = truth.position_m + OBSERVED_STD_M * noise[:3]
        return TargetPose(
            position_m=position_m,
            position_camera_m=(self._T_camera_world @ [*position_m, 1.0])[:3],
            yaw_rad=truth.yaw_rad + OBSERVED_STD_RAD * noise[3],
            covariance=np.diag(variances),
            time_s=truth.time_s,
            visible_fraction=1.0,
            is_usable=True,
        )
