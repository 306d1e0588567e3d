"""One flight from the first image to the last: the world, the pilot, and what is noted of both."""

import contextlib
import time
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from experiments.bearing_only.config import FlightRun
from experiments.bearing_only.controllers import ORACLES, get_controller
from experiments.bearing_only.oracles import KnownPose
from experiments.bearing_only.pilots import NoiseDraws, pilot_config, rng_of, slam_config
from experiments.bearing_only.sensor_models import SensorModel, sensor_model_of
from experiments.bearing_only.studies import world_of
from sim.bearing_only.flight import DRAWS, Flight, FlightDraws
from tracker.bearing_only.control import range_std
from tracker.bearing_only.measurements import (
    BodyIncrement,
    Measurements,
    MotionCommand,
    PoseBelief,
    TargetBelief,
)
from tracker.bearing_only.pilot import BearingPilot, TargetPrior
from tracker.bearing_only.pose_sources import DeadReckoning, FixAided, PoseSource
from tracker.bearing_only.slam import MonocularSlam

LEAST_PRIOR = 0.1
"""A guess of the range is not less than this share of the truth."""


class FlightLog:
    """What happened: a column for each thing that `_note` names, a value for each iteration.

    Iterations before the target was first seen have no values. Where several flights go on at once,
    each value has them on its first axis.
    """

    def __init__(self) -> None:
        self._columns: defaultdict[str, list[Any]] = defaultdict(list)
        self.step_s: list[float] = []
        """Wall-clock time of every step of the pilot."""

    def __len__(self) -> int:
        return len(self._columns["is_seen"])

    def note(self, **values: Any) -> None:
        """Appends a value to each of these columns."""
        for name, value in values.items():
            self._columns[name].append(value)

    def array(self, name: str) -> NDArray[np.float64]:
        """One column as an array (iterations, flights, ...)."""
        values = np.array(self._columns[name], float)
        is_single = np.ndim(self._columns["is_seen"][0]) == 0
        return values[:, None] if is_single else values


@dataclass(frozen=True, eq=False)
class Flown:
    """A finished flight, or one that broke off."""

    log: FlightLog
    flight: Flight
    source: PoseSource
    error: Exception | None = None


@dataclass(frozen=True, eq=False)
class Instant:
    """The state after one iteration, before the next motion.

    The properties are those of one flight, the first where several are flown at once.
    """

    flight: Flight
    pilot: BearingPilot
    source: PoseSource
    sensors: SensorModel
    motion: MotionCommand

    @property
    def robot_m(self) -> NDArray[np.float64]:
        """(3,): where the vehicle is."""
        return _first(self.flight.position_m, 1)

    @property
    def forward(self) -> NDArray[np.float64]:
        """(3,): where the vehicle looks, a unit vector in the world."""
        return _first(self.flight.R_world_body, 2)[:, 0]

    @property
    def target_m(self) -> NDArray[np.float64]:
        """(3,): where the target is."""
        return _first(self.flight.target_m, 1)

    @property
    def pose(self) -> PoseBelief:
        """Where the pilot takes itself to be."""
        pose = self.pilot.pose
        return PoseBelief(
            _first(pose.position_m, 1), _first(pose.R_world_body, 2), _first(pose.covariance, 2)
        )

    @property
    def target(self) -> TargetBelief | None:
        """Where the pilot takes the target to be; None before it was seen."""
        if not self.pilot.has_target:
            return None
        target = self.pilot.target
        return TargetBelief(
            _first(target.position_m, 1),
            _first(target.velocity_mps, 1),
            _first(target.covariance, 2),
        )

    @property
    def follow_mps(self) -> float:
        """The command's following part."""
        return float(_first(self.motion.follow_mps, 0))

    @property
    def aside_mps(self) -> float:
        """The size of the part that makes the range observable."""
        return float(np.linalg.norm(_first(self.motion.observability_mps, 1)))


def _first(values: NDArray[np.float64], axes: int) -> NDArray[np.float64]:
    """The last `axes` axes, of the first of several flights."""
    values = np.asarray(values)
    return values.reshape(-1, *values.shape[values.ndim - axes :])[0]


def fly(runs: Sequence[FlightRun], watch: Callable[[Instant], None] | None = None) -> Flown:
    """Flies one run, or several of an oracle's that differ in their seed alone.

    What breaks the pilot off (a measurement that is no number, a filter that fails) ends the
    flight and is told in `Flown.error`; what happened until then is kept.

    Args:
        runs: What to fly.
        watch: Is shown every iteration, as for a film; it changes nothing.
    """
    first, log = runs[0], FlightLog()
    is_single = get_controller(first.controller).pose not in ORACLES
    flight = _flight(runs, is_single)
    start = PoseBelief(
        flight.position_m, flight.R_world_body, np.zeros((*flight.position_m.shape[:-1], 6, 6))
    )
    noise = (flight.config.odometry_std_m, flight.config.odometry_std_rad)
    source, reckoning = _source(runs, flight, start), DeadReckoning(start, *noise)
    noise_draws = NoiseDraws([rng_of(run, "whims") for run in runs], is_single)
    pilot = BearingPilot(pilot_config(first), source, _prior(runs, flight, is_single), noise_draws)
    still = np.zeros_like(flight.position_m)
    odometry = BodyIncrement(still, still)
    with contextlib.closing(sensor_model_of(first, flight)) as sensors:
        for k in range(first.iteration_count):
            try:
                measurements = sensors.measure(odometry)
                started_s = time.perf_counter()
                motion = pilot.step(measurements)
            except (ValueError, ArithmeticError, np.linalg.LinAlgError) as error:
                return Flown(log, flight, source, error)
            log.step_s.append(time.perf_counter() - started_s)
            reckoned = reckoning.update(measurements)
            if pilot.has_target:
                _note(log, flight, pilot, motion, reckoned, measurements)
            if watch is not None:
                watch(Instant(flight, pilot, source, sensors, motion))
            odometry = motion.increment
            if k + 1 < first.iteration_count:
                flight.move(odometry.displacement_m, odometry.rotation_rad)
    return Flown(log, flight, source)


def _flight(runs: Sequence[FlightRun], is_single: bool) -> Flight:
    config = world_of(runs[0])
    draws = [FlightDraws.of(config, {name: rng_of(run, name) for name in DRAWS}) for run in runs]
    return Flight(config, draws[0] if is_single else FlightDraws.stack(draws))


def _source(runs: Sequence[FlightRun], flight: Flight, start: PoseBelief) -> PoseSource:
    run, noise = runs[0], (flight.config.odometry_std_m, flight.config.odometry_std_rad)
    kind = get_controller(run.controller).pose
    if kind == "slam":
        return MonocularSlam(slam_config(run), start)
    if kind == "dead-reckoning":
        return DeadReckoning(start, *noise)
    shape = (run.iteration_count, 3)
    draws = np.stack([rng_of(run, "pose-error").standard_normal(shape) for run in runs])
    oracle = KnownPose(flight, run.pose_error, run.pose_error_m, draws)
    if kind == "known":
        return oracle
    return FixAided(start, oracle, *noise)


def _prior(runs: Sequence[FlightRun], flight: Flight, is_single: bool) -> TargetPrior:
    """A rough guess of the range; with a good one (below 10 %) also one of the velocity."""
    run, draws = runs[0], np.stack([rng_of(run, "prior").standard_normal(4) for run in runs])
    if is_single:
        draws = draws[0]
    start_m, target_start_m = flight.config.start_m, flight.config.target.start_m
    distance_m = float(np.linalg.norm(np.subtract(target_start_m, start_m)))
    guess_m = distance_m * np.maximum(1.0 + run.range_prior * draws[..., 0], LEAST_PRIOR)
    std_m = np.full_like(guess_m, run.range_prior * distance_m)
    if run.range_prior < 0.1:
        velocity = np.array(flight.target_velocity_mps) + 0.5 * draws[..., 1:]
        return TargetPrior(guess_m, std_m, velocity, 0.5)
    return TargetPrior(guess_m, std_m, np.zeros_like(draws[..., 1:]), run.target_speed_mps)


def _note(
    log: FlightLog,
    flight: Flight,
    pilot: BearingPilot,
    motion: MotionCommand,
    reckoned: PoseBelief,
    measurements: Measurements,
) -> None:
    """Writes down truth and belief of this iteration."""
    pose, target = pilot.pose, pilot.target
    shape, S = flight.position_m.shape, pilot.innovation_covariance
    area = np.full(shape[:-1], np.nan) if S is None else np.pi * np.sqrt(np.linalg.det(S))
    log.note(
        robot_m=flight.position_m,
        robot_estimate_m=pose.position_m,
        robot_covariance=pose.covariance[..., :3, :3],
        reckoned_m=reckoned.position_m,
        target_m=np.broadcast_to(flight.target_m, shape),
        target_velocity_mps=np.broadcast_to(flight.target_velocity_mps, shape),
        target_estimate_m=target.position_m,
        velocity_estimate_mps=target.velocity_mps,
        target_covariance=target.covariance[..., :3, :3],
        sight_std_m=range_std(pose, target)[1],
        innovation_area_px2=area,
        follow_mps=motion.follow_mps,
        command_mps=motion.increment.displacement_m / flight.config.dt_s,
        aside_mps=motion.observability_mps,
        unseen_count=pilot.unseen_count,
        is_seen=pilot.unseen_count == 0,
        landmarks_in_view=len(measurements.features.ids),
    )
