"""What a flight leaves: its row, timings, error curve and, of a few, the whole flight."""

import time
import traceback
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from experiments.bearing_only.config import FlightResult, FlightRun, FlightTimings, Outcome
from experiments.bearing_only.flying import FlightLog, Flown, fly
from experiments.bearing_only.pilots import pilot_config
from experiments.bearing_only.traces import (
    CURVES,
    TRACES,
    curve_of,
    is_traced,
    map_of,
    trace_name,
    trace_of,
)
from experiments.study.provenance import code_version
from experiments.study.study import Result

ASTRAY_M = 0.5
"""A pose whose mean error is above this share of the room's scale has diverged, outdoors [m]."""
WARM_UP_S = 1.0
"""NEES counts after so much time: the start is known exactly, and so is its covariance."""


def fly_runs(runs: Sequence[FlightRun]) -> list[Result[FlightResult]]:
    """Flies one run, or several of an oracle's at once; a result for each.

    A flight whose pilot broke off has a row with `outcome` error and the traceback.
    """
    started_s = time.perf_counter()
    flown = fly(runs)
    rows = results_of(runs, flown, str(code_version()))
    wall_s = time.perf_counter() - started_s
    step_ms = 1e3 * np.array(flown.log.step_s or [np.nan])
    median_ms, p95_ms = float(np.median(step_ms)), float(np.percentile(step_ms, 95))
    error = None
    if flown.error is not None:
        error = "".join(traceback.format_exception(flown.error))
    return [
        Result(
            rows=(row,),
            timings=FlightTimings(run.run_id, run.controller, median_ms, p95_ms, len(runs), wall_s),
            curves={CURVES: curve_of(run, flown.log, index)},
            files=_traces(run, flown, index),
            error=error,
        )
        for index, (run, row) in enumerate(zip(runs, rows, strict=True))
    ]


def _traces(run: FlightRun, flown: Flown, index: int) -> dict[str, str]:
    """Path -> CSV of a flight that is kept whole; none of others."""
    if not (is_traced(run) and flown.log):
        return {}
    name = f"{TRACES}/{trace_name(run)}"
    traces = {f"{name}.csv": trace_of(flown.log, index)}
    landmarks = map_of(flown)
    return traces if landmarks is None else traces | {f"{name}_map.csv": landmarks}


def results_of(runs: Sequence[FlightRun], flown: Flown, commit: str) -> list[FlightResult]:
    """One row for each run of the flight."""
    if flown.error is not None or not flown.log:
        error = flown.error
        detail = (
            "the target was never seen" if error is None else f"{type(error).__name__}: {error}"
        )
        outcome: Outcome = "lost" if error is None else "error"
        return [failed_result(run, outcome, detail, commit) for run in runs]
    measures = _measures(runs[0], flown)
    return [
        FlightResult(
            **_identity(run),
            outcome=_outcome(run, flown.log, measures, index),
            **_cells(measures, index),
            commit=commit,
        )
        for index, run in enumerate(runs)
    ]


def failed_result(run: FlightRun, outcome: Outcome, detail: str, commit: str) -> FlightResult:
    """The row of a run that broke off, or never began: nothing is measured."""
    return FlightResult(**_identity(run), outcome=outcome, detail=detail[:1000], commit=commit)


def _identity(run: FlightRun) -> dict[str, Any]:
    return {"run_id": run.run_id, **asdict(run)}


def _cells(measures: dict[str, NDArray[np.float64]], index: int) -> dict[str, Any]:
    """Column -> number of one flight; None where there is none."""
    values = {name: float(column[index]) for name, column in measures.items()}
    cells: dict[str, Any] = {n: None if np.isnan(value) else value for n, value in values.items()}
    switch = cells["switch_iteration"]
    return cells | {"switch_iteration": None if switch is None else int(switch)}


def _outcome(
    run: FlightRun, log: FlightLog, measures: dict[str, NDArray[np.float64]], index: int
) -> Outcome:
    if run.pose_error == "none" and measures["robot_error_m"][index] > ASTRAY_M:
        return "diverged"
    unseen = log.array("unseen_count")[-1, index]
    return "lost" if unseen > pilot_config(run).lost_after else "tracked"


def _measures(run: FlightRun, flown: Flown) -> dict[str, NDArray[np.float64]]:
    """Column -> (flights,) values."""
    log, k = flown.log, len(flown.log)
    late, warm = slice(k // 2, None), slice(int(WARM_UP_S / flown.flight.config.dt_s), None)
    target = log.array("target_estimate_m") - log.array("target_m")
    robot = log.array("robot_estimate_m") - log.array("robot_m")
    velocity = log.array("velocity_estimate_mps") - log.array("target_velocity_mps")
    target_error, robot_error = (np.linalg.norm(e, axis=-1) for e in (target, robot))
    reckoned = np.linalg.norm(log.array("reckoned_m") - log.array("robot_m"), axis=-1)
    distance = np.linalg.norm(log.array("target_m") - log.array("robot_m"), axis=-1)
    sight, follow = log.array("sight_std_m"), np.abs(log.array("follow_mps"))
    with np.errstate(invalid="ignore"):
        switched = follow < 0.5 * run.v_max_mps
    first = np.where(switched.any(axis=0), switched.argmax(axis=0), np.nan)
    measures: dict[str, Any] = {
        "target_error_m": target_error.mean(axis=0),
        "target_error_late_m": target_error[late].mean(axis=0),
        "target_error_end_m": target_error[-1],
        "velocity_error_late_mps": np.linalg.norm(velocity[late], axis=-1).mean(axis=0),
        "robot_error_m": robot_error.mean(axis=0),
        "robot_error_max_m": robot_error.max(axis=0),
        "dead_reckoning_error_m": reckoned.mean(axis=0),
        "robot_nees": _nees(robot[warm], log.array("robot_covariance")[warm]),
        "target_nees": _nees(target[warm], log.array("target_covariance")[warm]),
        "sight_std_start_m": sight[0],
        "sight_std_max_m": sight.max(axis=0),
        "sight_std_late_m": sight[late].mean(axis=0),
        "switch_iteration": first,
        "seen_share": log.array("is_seen").mean(axis=0),
        "distance_mean_m": distance.mean(axis=0),
        "distance_min_m": distance.min(axis=0),
        "aside_speed_mps": _aside_speed(log, flown.flight.config.dt_s),
        "landmarks_in_view": np.full(len(target_error[0]), log.array("landmarks_in_view").mean()),
    }
    return measures


def _nees(error: NDArray[np.float64], covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    """(flights,): median over the iterations of e^T P^-1 e; NaN where P is zero (an oracle)."""
    missing = np.nan * np.ones(error.shape[1])
    if not len(error):
        return missing
    is_known = np.linalg.det(covariance).min(axis=0) > 0.0
    safe = np.where(is_known[:, None, None], covariance, np.eye(3))
    solved = np.asarray(np.linalg.solve(safe, error[..., None]), np.float64)[..., 0]
    squares = np.einsum("kfi,kfi->kf", error, solved)
    return np.where(is_known, np.median(squares, axis=0), missing)


def _aside_speed(log: FlightLog, dt_s: float) -> NDArray[np.float64]:
    """(flights,): mean speed of the vehicle across the line of sight."""
    robot, target = log.array("robot_m"), log.array("target_m")
    if len(robot) < 2:
        return np.nan * np.ones(robot.shape[1])
    velocity = np.diff(robot, axis=0) / dt_s
    sight = (target - robot)[:-1]
    sight = sight / np.linalg.norm(sight, axis=-1, keepdims=True)
    along = np.einsum("kfi,kfi->kf", velocity, sight)[..., None] * sight
    return np.linalg.norm(velocity - along, axis=-1).mean(axis=0)
