"""Scoring on made-up traces whose answers can be worked out by hand."""

import math
from collections.abc import Iterable

import numpy as np
import pytest

from experiments.belt.config import TrialConfig
from experiments.belt.metrics import classify, root_mean_square, score
from experiments.belt.trace import ControlSample, EstimateSample, TrialTrace
from sim.arm.grasp import Phase
from sim.belt.referee import PhysicalRecord
from tracker.base import Status

DT = 1.0 / 120.0
SPEED_MPS = 0.2
P = Phase


def control(times: Iterable[float], phase: Phase, *, error: float | None = 0.5) -> list:
    return [
        ControlSample(
            time_s=t,
            phase=phase,
            true_position_m=np.array([0.5, SPEED_MPS * t, 0.08]),
            true_yaw_rad=1.0,
            servo_error=error,
            true_error=0.4,
            is_feasible=True,
        )
        for t in times
    ]


def estimates(times: Iterable[float], *, offset_m: float = 0.003, turn_rad: float = 0.02) -> list:
    """Poses off by `offset_m` along x and `turn_rad`."""
    return [
        EstimateSample(
            time_s=t,
            position_m=np.array([0.5 + offset_m, SPEED_MPS * t, 0.08]),
            yaw_rad=1.0 + turn_rad + math.pi,
            status=Status.TRACKING,
            ess=100.0,
            visible_fraction=0.9,
        )
        for t in times
    ]


def blind(times: Iterable[float], status: Status = Status.SEARCHING) -> list:
    return [EstimateSample(t, None, None, status, None, None) for t in times]


def trace(phases: dict[Phase, float], end_s: float, seen: list) -> TrialTrace:
    """Phases with their start times, up to `end_s`."""
    starts = [*phases.values(), end_s]
    samples = []
    for phase, start, stop in zip(phases, starts, starts[1:], strict=False):
        samples += control(np.arange(start, stop, DT), phase)
    return TrialTrace(samples, seen)


FULL = {P.SEARCH: 0.0, P.TRACK: 0.3, P.APPROACH: 0.4, P.SYNC: 1.0, P.DESCEND: 1.1, P.CLOSE: 1.5}
SEEN = blind(np.arange(0, 0.2, 1 / 30)) + estimates(np.arange(0.2, 2.0, 1 / 30))
GRIPPED = PhysicalRecord(close_command_s=1.5, first_touch_s=1.7, gripped_s=1.75)


def test_errors_are_those_of_the_poses_before_sync():
    late = estimates(np.arange(1.0, 2.0, 1 / 30), offset_m=0.5)
    early = estimates(np.arange(0.2, 1.0, 1 / 30))
    measured = score(TrialConfig(), trace(FULL, 2.0, early + late), GRIPPED, 0.1)
    assert measured["track_rmse_m"] == pytest.approx(0.003)
    assert measured["track_yaw_rmse_rad"] == pytest.approx(0.02)  # modulo half a turn


def test_times_count_from_full_view():
    record = PhysicalRecord(close_command_s=1.5, lifted_off_s=2.1, held_s=1.0)
    measured = score(TrialConfig(), trace(FULL, 3.2, SEEN), record, 0.1)
    assert measured["time_to_track_s"] == pytest.approx(0.1, abs=1e-6)
    assert measured["time_to_sync_s"] == pytest.approx(0.9, abs=DT)
    assert measured["time_to_grasp_s"] == pytest.approx(2.0)
    assert measured["belt_used_m"] == pytest.approx(2.0 * SPEED_MPS)


def test_what_never_happened_is_empty():
    measured = score(TrialConfig(), trace({P.SEARCH: 0.0}, 1.0, []), PhysicalRecord(), 0.0)
    empty = [
        "time_to_track_s",
        "time_to_sync_s",
        "time_to_grasp_s",
        "belt_used_m",
        "track_rmse_m",
        "close_error_m",
        "in_hand_slip_m",
        "median_ess",
        "visible_fraction_min",
    ]
    assert all(measured[name] is None for name in empty)


def test_criterion_is_about_belief_not_about_the_grasp():
    met = TrialTrace(control(np.arange(0, 1, DT), P.CLOSE, error=0.01), SEEN)
    measured = score(TrialConfig(error_threshold=0.02), met, PhysicalRecord(has_left=True), 0.0)
    assert measured["criterion_met"] and not measured["success"]
    missed = TrialTrace(control(np.arange(0, 1, DT), P.CLOSE, error=0.03), SEEN)
    assert not score(TrialConfig(), missed, PhysicalRecord(), 0.0)["criterion_met"]


def test_losses_are_counted_once_each():
    T, L = Status.TRACKING, Status.LOST
    statuses = [T, L, L, T, L]
    seen = [EstimateSample(0.1 * i, None, None, s, None, None) for i, s in enumerate(statuses)]
    measured = score(TrialConfig(), trace(FULL, 2.0, seen), PhysicalRecord(), 0.0)
    assert measured["lost_count"] == 2


UNTIL_TRACK = {P.SEARCH: 0.0, P.TRACK: 0.3, P.APPROACH: 0.4}
GAP = estimates(np.arange(0.2, 0.5, 1 / 30)) + estimates(np.arange(1.2, 2.0, 1 / 30))


@pytest.mark.parametrize(
    ("expected", "made", "record"),
    [
        ("success", trace(FULL, 3.0, SEEN), PhysicalRecord(held_s=1.0)),
        ("collision", trace(FULL, 3.0, SEEN), PhysicalRecord(collision="hand and belt")),
        ("never_detected", trace({P.SEARCH: 0.0}, 3.0, blind([0.1, 0.2])), PhysicalRecord()),
        ("knocked", trace(FULL, 3.0, SEEN), PhysicalRecord(first_touch_s=1.2)),
        ("lost_track", trace(UNTIL_TRACK, 2.0, GAP), PhysicalRecord(has_left=True)),
        ("left_belt", trace(UNTIL_TRACK, 2.0, SEEN), PhysicalRecord(has_left=True)),
        ("timeout", trace(UNTIL_TRACK, 2.0, SEEN), PhysicalRecord()),
        ("missed", trace(FULL, 3.0, SEEN), PhysicalRecord(close_command_s=1.5)),
        ("slipped", trace(FULL, 3.0, SEEN), GRIPPED),
    ],
)
def test_first_cause_of_failure(expected, made, record):
    assert classify(made, record) == expected


def test_dropped_is_risen_then_fallen():
    record = PhysicalRecord(
        close_command_s=1.5, first_touch_s=1.7, gripped_s=1.75, lifted_off_s=2.0, max_height_m=0.09
    )
    assert classify(trace(FULL, 3.0, SEEN), record) == "dropped"
    record.max_height_m = 0.02
    assert classify(trace(FULL, 3.0, SEEN), record) == "slipped"


def test_infeasible_motion_is_named():
    made = trace(UNTIL_TRACK, 2.0, SEEN)
    first = made.control[0]
    made.control[0] = ControlSample(**{**vars(first), "is_feasible": False})
    assert classify(made, PhysicalRecord(has_left=True)) == "infeasible_ik"


def test_root_mean_square_of_nothing_is_nothing():
    assert root_mean_square(np.array([])) is None
    assert root_mean_square(np.array([3.0, -4.0])) == pytest.approx(math.sqrt(12.5))
