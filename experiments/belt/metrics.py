"""From a trace and the referee's record to one row: what happened, how well, and why not."""

import itertools
import math

import numpy as np

from experiments.belt.config import Outcome, TrialConfig
from experiments.belt.trace import TrialTrace
from sim.arm.grasp import Phase
from sim.belt.referee import PhysicalRecord
from tracker.base import Status

LOST_S = 0.5
"""Without a usable pose for this long before SYNC, the track counts as lost."""
DROP_HEIGHT_M = 0.03


def root_mean_square(values: np.ndarray) -> float | None:
    """Square root of the mean square; None of nothing."""
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else None


def classify(trace: TrialTrace, record: PhysicalRecord) -> Outcome:
    """Success, or the first cause of failure in the order in which causes can act."""
    if record.is_success:
        return "success"
    if record.collision:
        return "collision"
    if all(sample.position_m is None for sample in trace.estimates):
        return "never_detected"
    closed_s = trace.first_entry_s(Phase.CLOSE)
    if record.is_early_contact:
        return "knocked"
    if closed_s is None:
        return _why_not_closed(trace, record)
    if record.gripped_s is None:
        return "missed"
    if record.lifted_off_s is None:
        return "slipped"
    return "dropped" if record.max_height_m > DROP_HEIGHT_M else "slipped"


def _why_not_closed(trace: TrialTrace, record: PhysicalRecord) -> Outcome:
    if _longest_gap_s(trace) > LOST_S:
        return "lost_track"
    if not all(sample.is_feasible for sample in trace.control):
        return "infeasible_ik"
    return "left_belt" if record.has_left or record.has_fallen else "timeout"


def _longest_gap_s(trace: TrialTrace) -> float:
    """Longest time without a usable pose, from the first one until SYNC or the end."""
    end_s = trace.first_entry_s(Phase.SYNC) or trace.control[-1].time_s
    times = [e.time_s for e in trace.estimates if e.position_m is not None and e.time_s < end_s]
    return float(np.max(np.diff([*times, end_s]))) if times else 0.0


def score(
    config: TrialConfig, trace: TrialTrace, record: PhysicalRecord, entered_view_s: float
) -> dict[str, object]:
    """The measured columns of a row; `results/README.md` defines each.

    Args:
        config: What was tried.
        trace: What happened, as recorded by the loop.
        record: What happened, as judged by physics.
        entered_view_s: When the whole object was first in the camera's view.
    """
    sync_s, first_pose_s = trace.first_entry_s(Phase.SYNC), _first_pose_s(trace)
    distances, turns = trace.errors_until(math.inf if sync_s is None else sync_s)
    servo_errors = [s.servo_error for s in trace.control if s.servo_error is not None]
    grip_error = record.grip_error_m
    return {
        "outcome": classify(trace, record),
        "success": record.is_success,
        "clean_success": record.is_clean_success,
        "criterion_met": bool(servo_errors) and min(servo_errors) < config.error_threshold,
        "time_to_track_s": _since(entered_view_s, first_pose_s),
        "time_to_sync_s": _since(entered_view_s, sync_s),
        "time_to_grasp_s": _since(entered_view_s, record.lifted_off_s),
        "belt_used_m": _belt_used_m(trace, record, entered_view_s),
        "track_rmse_m": root_mean_square(distances),
        "track_yaw_rmse_rad": root_mean_square(turns),
        "close_error_m": None if grip_error is None else float(np.linalg.norm(grip_error)),
        "close_error_closing_axis_m": None if grip_error is None else float(grip_error[0]),
        "close_yaw_error_rad": record.grip_yaw_error_rad,
        "in_hand_slip_m": record.slip_m,
        "max_tilt_rad": record.max_tilt_rad,
        "is_early_contact": record.is_early_contact,
        "median_ess": _median([e.ess for e in trace.estimates]),
        "lost_count": _lost_count(trace),
        "visible_fraction_min": min(
            (e.visible_fraction for e in trace.estimates if e.visible_fraction is not None),
            default=None,
        ),
        "simulated_s": trace.control[-1].time_s,
        "detail": record.collision,
    }


def _first_pose_s(trace: TrialTrace) -> float | None:
    return next((e.time_s for e in trace.estimates if e.position_m is not None), None)


def _since(start_s: float, event_s: float | None) -> float | None:
    return None if event_s is None else event_s - start_s


def _belt_used_m(trace: TrialTrace, record: PhysicalRecord, entered_view_s: float) -> float | None:
    """Length of the object's way, straight or round, up to lift-off."""
    if record.lifted_off_s is None:
        return None
    times = [s.time_s for s in trace.control]
    steps_m = np.diff([s.true_position_m[:2] for s in trace.control], axis=0)
    way_m = np.concatenate([[0.0], np.cumsum(np.linalg.norm(steps_m, axis=1))])
    return float(np.diff(np.interp([entered_view_s, record.lifted_off_s], times, way_m))[0])


def _median(values: list[float | None]) -> float | None:
    known = [v for v in values if v is not None]
    return float(np.median(known)) if known else None


def _lost_count(trace: TrialTrace) -> int:
    """How often a track that had been usable turned to lost."""
    statuses = [e.status for e in trace.estimates]
    changes = itertools.pairwise(statuses)
    return sum(after is Status.LOST and before is not Status.LOST for before, after in changes)
