"""The tables of a sweep, worked out by hand on a few rows."""

import dataclasses
import math

import pytest
from toy_trial import trials_of

from experiments.belt.analysis.cell_tables import (
    blame_table,
    cost_table,
    outcome_table,
    success_table,
    tracking_table,
)
from experiments.belt.config import TrialConfig, TrialTimings
from experiments.belt.presets import expand


@pytest.fixture
def results(make_row):
    cells = expand(tracker=["igpf", "pf"], speed_mps=[0.1, 0.5])
    return [make_row(config) for config in trials_of(cells, range(10))]


@pytest.fixture
def pair(make_row):
    """One cell of four trials: three successes, two of them clean."""
    errors_m = [0.001, 0.003, None, 0.002]
    ends = [("success", True), ("success", True), ("success", False), ("missed", False)]
    return [
        make_row(
            TrialConfig(seed=seed),
            outcome=outcome,
            success=outcome == "success",
            clean_success=clean,
            criterion_met=seed == 0,
            time_to_grasp_s=2.0 + seed,
            track_rmse_m=error_m,
            track_yaw_rmse_rad=math.radians(1.5),
        )
        for seed, ((outcome, clean), error_m) in enumerate(zip(ends, errors_m, strict=True))
    ]


def test_the_measures_of_a_cell_by_hand(pair):
    (row,) = success_table(pair).rows
    assert (row["n"], row["success_count"], row["success_rate"]) == (4, 3, 0.75)
    assert (row["clean_rate"], row["criterion_rate"]) == (0.5, 0.25)
    assert row["success_low"] == pytest.approx(0.3006, abs=1e-4)
    assert row["success_high"] == pytest.approx(0.9544, abs=1e-4)
    assert row["mean_time_to_grasp_s"] == pytest.approx(3.0), "successes only"
    assert row["median_track_rmse_mm"] == pytest.approx(2.0)
    assert row["median_track_yaw_rmse_deg"] == pytest.approx(1.5)


def test_a_cell_without_measurements_has_empty_cells(make_row):
    row = make_row(
        TrialConfig(), success=False, outcome="error", track_rmse_m=None, time_to_grasp_s=None
    )
    table = success_table([row])
    assert table.rows[0]["median_track_rmse_mm"] is None
    assert ",,," not in table.to_csv().splitlines()[0]
    assert "| - |" in table.to_markdown()


def test_the_gap_is_what_the_criterion_grants_beyond_physics(pair, make_row):
    (row,) = success_table(pair).rows
    assert row["criterion_gap"] == pytest.approx(0.25 - 0.75)
    believed = [make_row(TrialConfig(seed=s), success=s == 0, criterion_met=True) for s in (0, 1)]
    assert success_table(believed).rows[0]["criterion_gap"] == pytest.approx(0.5)


def test_tracking_has_medians_of_what_happened_and_sums_of_losses(make_row):
    rows = [
        make_row(TrialConfig(seed=seed), time_to_sync_s=time_s, median_ess=10.0, lost_count=lost)
        for seed, (time_s, lost) in enumerate([(1.0, 0), (2.0, 3), (None, 1), (9.0, 0)])
    ]
    (row,) = tracking_table(rows).rows
    assert (row["n"], row["time_to_sync_s"], row["time_to_sync_s_n"]) == (4, 2.0, 3)
    assert (row["median_ess"], row["lost_count"], row["loser_count"]) == (10.0, 4, 2)


def test_costs_are_medians_of_the_trials_that_did_not_crash(make_row):
    rows = [make_row(TrialConfig(seed=seed)) for seed in range(4)]
    rows[3] = dataclasses.replace(rows[3], outcome="error")
    timings = [
        TrialTimings(row.trial_id, wall_s, 5.0, 10.0 * wall_s, None, 0.1, 0.2)
        for row, wall_s in zip(rows, (1.0, 2.0, 7.0, 99.0), strict=True)
    ]
    (row,) = cost_table(rows, timings).rows
    assert (row["n"], row["wall_s"], row["render_ms_per_image"]) == (3, 2.0, 20.0)
    assert row["track_ms_per_image"] is None
    assert row["real_time_factor"] == pytest.approx(1.5)
    assert not cost_table(rows, []).rows


def test_outcomes_add_up(results):
    for row in outcome_table(results).rows:
        counts = [value for key, value in row.items() if key in ("success", "missed", "lost_track")]
        assert sum(counts) == row["n"] == 10


def test_a_failure_is_the_tracker_s_where_the_oracle_succeeds(make_row):
    """Seed 0 both, 1 the tracker fails, 2 both fail, 3 the oracle did not try."""
    ends = {"oracle": (True, True, False), "igpf": (True, False, False, False)}
    rows = [
        make_row(
            TrialConfig(
                tracker=name, seed=seed, condition="normal" if name == "oracle" else "dark-3"
            ),
            outcome="success" if success else "missed",
            success=success,
        )
        for name, successes in ends.items()
        for seed, success in enumerate(successes)
    ]
    (row,) = blame_table(rows).rows
    named = ("tracker", "n", "failures", "tracking", "arm", "unknown")
    assert tuple(row[name] for name in named) == ("igpf", 4, 3, 1, 1, 1)
    assert not blame_table([row for row in rows if row.tracker != "oracle"]).rows
    assert not blame_table([row for row in rows if row.success]).rows
