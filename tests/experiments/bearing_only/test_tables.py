"""The tables of flights, worked out by hand on a few rows."""

import math

import pytest

from experiments.bearing_only.config import FlightResult, FlightRun, FlightTimings
from experiments.bearing_only.tables import behaviour_table, cost_table, error_table, ratio_table


def flight(controller, seed, error_m=None, *, outcome="tracked", setting=None, **measured):
    run = FlightRun("circle", controller, seed, **(setting or {}))
    return FlightResult(
        run.run_id,
        run.study,
        run.controller,
        run.seed,
        run.v_max_mps,
        run.target_speed_mps,
        run.range_prior,
        run.landmark_count,
        run.iteration_count,
        run.pose_error,
        run.pose_error_m,
        outcome=outcome,
        target_error_m=error_m,
        **measured,
    )


@pytest.fixture
def gradient():
    """Three flights, one of which broke off."""
    return [
        flight("gradient", 0, 1.0, robot_error_m=0.1, dead_reckoning_error_m=0.4,
               target_error_late_m=0.5),
        flight("gradient", 1, outcome="error"),
        flight("gradient", 2, 3.0, robot_error_m=0.3, dead_reckoning_error_m=0.6,
               target_error_late_m=2.5, outcome="lost"),
    ]  # fmt: skip


def test_errors_are_means_over_the_flights_that_have_them(gradient):
    (row,) = error_table(gradient).rows
    assert (row["controller"], row["n"], row["tracked"]) == ("gradient", 3, 1)
    assert (row["target_error_m_mean"], row["target_error_m_max"]) == (2.0, 3.0)
    assert row["target_error_m_std"] == pytest.approx(math.sqrt(2.0)), "n - 1 in the denominator"
    assert 1.0 <= row["target_error_m_low"] < 2.0 < row["target_error_m_high"] <= 3.0
    assert (row["robot_error_m_mean"], row["robot_error_m_max"]) == (pytest.approx(0.2), 0.3)
    assert row["target_error_late_m"] == 1.5
    assert row["dead_reckoning_error_m"] == 0.5
    assert row["robot_over_dead_reckoning"] == pytest.approx(0.4)
    shown = error_table(gradient).to_markdown().splitlines()[2]
    assert shown.startswith("| gradient | 3 | 1 | 2.000 ± 1.414 | [")
    assert shown.endswith("| 3.00 | 1.500 | 0.200 ± 0.141 | 0.30 | 0.500 | 0.40 |")


def test_a_cell_whose_flights_all_broke_off_has_empty_cells():
    table = error_table([flight("gradient", 0, outcome="error")])
    assert table.to_markdown().splitlines()[2] == (
        "| gradient | 1 | 0 | - | - | - | - | - | - | - | - |"
    )
    named = ("gradient", 1, 0)
    assert tuple(table.rows[0].values()) == named + (None,) * (len(table.rows[0]) - 3)


def test_one_flight_has_no_deviation_and_no_reckoning_no_ratio():
    table = error_table(
        [flight("known-pose", 0, 1.25, robot_error_m=0.0, dead_reckoning_error_m=0.0)]
    )
    (row,) = table.rows
    assert math.isnan(row["target_error_m_std"])
    assert (row["target_error_m_low"], row["target_error_m_high"]) == (1.25, 1.25)
    assert row["robot_over_dead_reckoning"] is None
    assert "| 1.250 ± - | [1.250, 1.250] |" in table.to_markdown()


def test_cells_are_named_by_the_controller_and_by_what_varies(gradient):
    slow = flight("gradient", 0, 5.0, setting={"v_max_mps": 1.0, "landmark_count": 0})
    table = error_table([*gradient, slow])
    assert [(row["v_max_mps"], row["landmark_count"], row["n"]) for row in table.rows] == [
        (2.5, 100, 3),
        (1.0, 0, 1),
    ]
    head, _, first, second = table.to_markdown().splitlines()
    assert head.startswith("| v_max [m/s] | landmarks | controller | n |")
    assert first.startswith("| 2.5 | 100 | gradient |") and second.startswith("| 1 | 0 | gradient")


def test_behaviour_is_medians_means_and_the_least():
    rows = [
        flight("turn", seed, 1.0, robot_nees=nees, sight_std_max_m=std, switch_iteration=switch,
               seen_share=share, distance_min_m=distance)
        for seed, (nees, std, switch, share, distance) in enumerate(
            [(1.0, 1.0, 10, 1.0, 7.0), (2.0, 2.0, None, 0.5, 5.0), (9.0, 6.0, 20, 0.75, 6.0)]
        )
    ]  # fmt: skip
    table = behaviour_table(rows)
    (row,) = table.rows
    assert (row["robot_nees"], row["sight_std_max_m"]) == (2.0, 3.0)
    assert (row["switch_iteration"], row["seen_share"], row["distance_min_m"]) == (15.0, 0.75, 5.0)
    assert row["target_nees"] is None
    shown = table.to_markdown().splitlines()[2]
    assert shown == "| turn | 2.00 | - | - | 3.00 | - | 15 | 75.0 | - | 5.0 | - | - |"


def test_ratios_are_of_means_over_the_seeds_that_both_have(gradient):
    rival = [flight("turn", seed, error_m) for seed, error_m in ((2, 1.0), (0, 2.0), (1, 9.0))]
    alone = flight("follow", 1, 1.0)
    table = ratio_table([*rival, *gradient, alone])
    (row,) = table.rows
    assert (row["controller"], row["n"], row["better"]) == ("turn", 2, 1)
    assert row["ratio"] == pytest.approx((2.0 + 1.0) / (1.0 + 3.0))
    assert 1.0 / 3.0 <= row["low"] < 0.75 < row["high"] <= 2.0
    assert table.to_markdown().splitlines()[2].startswith("| turn | 2 | 0.75 | [")


def test_ratios_are_within_a_setting_in_the_order_of_the_controllers():
    rows = [
        flight(name, 0, error_m, setting={"range_prior": prior})
        for prior, errors in ((0.2, (2.0, 1.0, 4.0)), (0.03, (1.0, 3.0, 3.0)))
        for name, error_m in zip(("gradient", "turn", "log-det"), errors, strict=True)
    ]
    found = [(r["range_prior"], r["controller"], r["ratio"]) for r in ratio_table(rows).rows]
    assert found == [(0.2, "log-det", 2.0), (0.2, "turn", 0.5),
                     (0.03, "log-det", 3.0), (0.03, "turn", 3.0)]  # fmt: skip


def test_there_is_no_ratio_without_the_reference(gradient):
    assert not ratio_table([flight("turn", 0, 1.0)]).rows
    assert not ratio_table(gradient).rows


def test_costs_are_medians_by_controller_and_landmarks():
    rows = [flight("turn", seed, 1.0) for seed in range(4)]
    rows.append(flight("turn", 0, 1.0, setting={"landmark_count": 0}))
    costs = [(1.0, 2.0, 1), (3.0, 8.0, 1), (9.0, 9.0, 5), (None, None, 7), (math.nan, math.nan, 1)]
    timings = [
        FlightTimings(row.run_id, row.controller, *cost, 60.0)
        for row, cost in zip(rows, costs, strict=True)
    ]
    table = cost_table(rows, timings)
    (row,) = table.rows
    assert (row["n"], row["landmark_count"], row["flights_at_once"]) == (3, 100, 5)
    assert (row["step_median_ms"], row["step_p95_ms"]) == (3.0, 8.0)
    assert table.to_markdown().splitlines()[2] == "| turn | 100 | 3 | 5 | 3.00 | 8.00 |"
    assert not cost_table(rows, []).rows
