"""Estimator and controller in one: the pose, then the target, then the motion."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tracker.bearing_only.control import (
    ControlConfig,
    DifferentialDrive,
    WheelDrive,
    aim,
    command,
    follow,
    manoeuvre_direction,
    unit,
)
from tracker.bearing_only.measurements import (
    BodyIncrement,
    Measurements,
    MotionCommand,
    PinholeCamera,
    PoseBelief,
    Status,
    TargetBelief,
)
from tracker.bearing_only.pose_sources import PoseSource
from tracker.bearing_only.target_cubature import CubatureFilter
from tracker.bearing_only.target_filter import StraightFilter, TargetNoise, TurnFilter
from tracker.bearing_only.target_mixture import MixtureFilter
from tracker.checks import require_choice, require_count, require_positive

TargetModel: TypeAlias = Literal["straight", "cubature", "turn", "mixture"]
"""Constant velocity by EKF, as [Wu2022], or by a square-root cubature filter; a turn whose rate is
estimated; both mixed."""

TargetFilter: TypeAlias = StraightFilter | CubatureFilter | TurnFilter | MixtureFilter
"""A filter of one target, or of as many as there are leading axes."""

NormalDraws: TypeAlias = Callable[[], NDArray[np.float64]]
"""Draws the (..., 3) standard normal numbers of the next step."""

TARGET_FILTERS = {
    "straight": StraightFilter,
    "cubature": CubatureFilter,
    "turn": TurnFilter,
    "mixture": MixtureFilter,
}


@dataclass(frozen=True)
class TargetPrior:
    """What is known of the target before the first image: only a rough range."""

    range_m: float | NDArray[np.float64]
    """(...,): guessed distance along the first ray."""
    range_std_m: float | NDArray[np.float64]
    """(...,): how rough the guess is."""
    velocity_mps: tuple[float, float, float] | NDArray[np.float64] = (0.0, 0.0, 0.0)
    velocity_std_mps: float = 2.0

    def __post_init__(self) -> None:
        for name in ("range_m", "range_std_m", "velocity_std_mps"):
            value = np.asarray(getattr(self, name))
            if not (np.isfinite(value).all() and (value > 0).all()):
                raise ValueError(f"{name} must be a positive number, got {value.min()}")


@dataclass(frozen=True)
class PilotConfig:
    """Settings of a pilot."""

    camera: PinholeCamera = field(default_factory=PinholeCamera)
    control: ControlConfig = field(default_factory=ControlConfig)
    target_model: TargetModel = "mixture"
    target_noise: TargetNoise = field(default_factory=TargetNoise)
    dt_s: float = 0.05
    drive: DifferentialDrive | None = None
    """Wheels that the motion is converted to; None for a vehicle that moves as it likes."""
    lost_after: int = 60
    """Iterations without sight of the target after which it is given up."""

    def __post_init__(self) -> None:
        require_choice(self, "target_model", tuple(TARGET_FILTERS))
        require_positive(self, "dt_s")
        require_count(self, "lost_after")


class BearingPilot:
    """Follows a target with one camera.  Source: [Wu2022] Fig. 2.

    The target starts along its first pixel at the prior's range. Before that the vehicle waits.
    """

    def __init__(
        self, config: PilotConfig, source: PoseSource, prior: TargetPrior, draws: NormalDraws
    ) -> None:
        self.config = config
        self._source, self._prior, self._draws = source, prior, draws
        self._filter: TargetFilter | None = None
        self._wheels = None if config.drive is None else WheelDrive(config.drive)
        self._pose: PoseBelief | None = None
        self._target: TargetBelief | None = None
        self._unseen = np.zeros((), int)
        self.innovation_covariance: NDArray[np.float64] | None = None
        """(..., 2, 2) of the target's pixel at the last step; None before it was seen."""

    @property
    def pose(self) -> PoseBelief:
        """Where it takes itself to be after the last step; ValueError before the first."""
        if self._pose is None:
            raise ValueError("the pilot has no pose before its first step")
        return self._pose

    @property
    def target(self) -> TargetBelief:
        """Where it takes the target to be after the last step; ValueError before it was seen."""
        if self._target is None:
            raise ValueError("the pilot has no target before it has seen it")
        return self._target

    @property
    def has_target(self) -> bool:
        """Whether the target was ever seen."""
        return self._target is not None

    @property
    def unseen_count(self) -> NDArray[np.int64]:
        """(...,): iterations since the target was last seen."""
        return self._unseen

    @property
    def status(self) -> Status:
        """How the track stands; of several runs the worst."""
        unseen = int(self._unseen.max())
        if unseen == 0:
            return "tracking"
        return "predicting" if unseen <= self.config.lost_after else "lost"

    def step(self, measurements: Measurements) -> MotionCommand:
        """One iteration: localise, update the target, look at it, and move."""
        self._pose = pose = self._source.update(measurements)
        pixel, is_seen = self._sight(measurements)
        self._unseen = np.where(is_seen, 0, self._unseen + 1)
        if self._filter is None:
            if not is_seen.all():
                return self._wait()
            self._filter = self._first_sight(pixel)
        else:
            self.innovation_covariance = self._filter.update(pixel, pose, is_seen)
        self._target = target = self._filter.belief
        self._filter.predict()
        return self._motion(pose, target, self._filter.belief, pixel, is_seen)

    def _sight(self, measurements: Measurements) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """(..., 2) pixels, any where the target is not seen, and (...,) where it is."""
        leading = self.pose.position_m.shape[:-1]
        pixel = measurements.target_px
        if pixel is None:
            return np.zeros((*leading, 2)), np.zeros(leading, bool)
        if measurements.is_target_seen is None:
            return pixel, np.ones(leading, bool)
        return pixel, measurements.is_target_seen

    def _wait(self) -> MotionCommand:
        zero = np.zeros_like(self.pose.position_m)
        return MotionCommand(BodyIncrement(zero, zero), zero[..., 0], zero)

    def _first_sight(self, pixel: NDArray[np.float64]) -> TargetFilter:
        prior = first_belief(self.config, self._prior, self.pose, pixel)
        make = TARGET_FILTERS[self.config.target_model]
        return make(self.config.camera, self.config.target_noise, prior, self.config.dt_s)

    def _motion(
        self,
        pose: PoseBelief,
        target: TargetBelief,
        predicted: TargetBelief,
        pixel: NDArray[np.float64],
        is_seen: NDArray[np.bool_],
    ) -> MotionCommand:
        control, camera = self.config.control, self.config.camera
        offset = unit(target.position_m - pose.position_m)
        believed = np.einsum("...ji,...j->...i", pose.R_world_body, offset)
        rays = np.where(is_seen[..., None], camera.rays_body(pixel), believed)
        direction = manoeuvre_direction(
            control.manoeuvre,
            camera,
            pose,
            predicted,
            self.config.target_noise.pixel_std_px,
            self._draws(),
        )
        if self.config.drive is not None:
            direction = unit(direction * np.array([1.0, 1.0, 0.0]))
        speed = follow(control, pose, target)
        free = command(control, self.config.dt_s, speed, direction, aim(rays))
        if self._wheels is None:
            return free
        wanted_mps = free.increment.displacement_m / self.config.dt_s
        increment = self._wheels.convert(wanted_mps, rays, self.config.dt_s)
        return replace(free, increment=increment)


def first_belief(
    config: PilotConfig, prior: TargetPrior, pose: PoseBelief, pixel: NDArray[np.float64]
) -> TargetBelief:
    """The target on the ray of its first pixel, as uncertain as the prior says and the pixel is."""
    ray = np.einsum("...ij,...j->...i", pose.R_world_body, config.camera.rays_body(pixel))
    range_m = np.broadcast_to(np.asarray(prior.range_m, float), ray.shape[:-1])[..., None]
    along = ray[..., :, None] * ray[..., None, :]
    focal_px = min(config.camera.s_u_px, config.camera.s_v_px)
    across_m = range_m * config.target_noise.pixel_std_px / focal_px
    range_std_m = np.broadcast_to(np.asarray(prior.range_std_m, float), ray.shape[:-1])
    P = np.zeros((*ray.shape[:-1], 6, 6))
    P[..., :3, :3] = (
        range_std_m[..., None, None] ** 2 * along
        + across_m[..., None] ** 2 * (np.eye(3) - along)
        + pose.covariance[..., :3, :3]
    )
    P[..., 3:, 3:] = prior.velocity_std_mps**2 * np.eye(3)
    velocity = np.broadcast_to(np.asarray(prior.velocity_mps, float), ray.shape).copy()
    return TargetBelief(pose.position_m + range_m * ray, velocity, P)
