import csv
import math

import pytest

from experiments.config import TrialConfig
from experiments.presets import Preset, expand
from experiments.tables import (
    blame_table,
    outcome_table,
    paired_table,
    show_number,
    success_table,
)


@pytest.fixture
def results(make_row):
    cells = expand(tracker=["igpf", "pf"], speed_mps=[0.1, 0.5])
    return [make_row(config) for config in Preset("p", "", cells, tuple(range(10))).trials]


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


def test_csv_markdown_and_text_hold_the_same_cells(results):
    table = success_table(results)
    rows = list(csv.DictReader(table.to_csv().splitlines()))
    assert [row["tracker"] for row in rows] == ["igpf", "igpf", "pf", "pf"]
    assert [float(row["speed_mps"]) for row in rows] == [0.1, 0.5, 0.1, 0.5]
    assert float(rows[0]["success_rate"]) == table.rows[0]["success_rate"]
    markdown = table.to_markdown().splitlines()
    assert len(markdown) == 2 + 4
    assert {line.count("|") for line in markdown} == {len(table.columns) + 1}
    text = table.to_text().splitlines()
    assert len({len(line) for line in text}) == 1, "right-aligned numbers end in one column"
    assert text[0].startswith("tracker  camera")


def test_outcomes_add_up(results):
    for row in outcome_table(results).rows:
        counts = [value for key, value in row.items() if key in ("success", "missed", "lost_track")]
        assert sum(counts) == row["n"] == 10


def test_pairs_are_matched_by_seed(make_row):
    succeeded = {"igpf": [True, True, True, False], "pf": [True, False, False, True]}
    rows = [
        make_row(TrialConfig(tracker=tracker, seed=seed), success=success)
        for tracker, outcomes in succeeded.items()
        for seed, success in enumerate(outcomes)
    ]
    extra = make_row(TrialConfig(tracker="pf", seed=9))
    table = paired_table([*rows, extra])
    assert table is not None
    (row,) = table.rows
    assert (row["tracker"], row["n"]) == ("pf", 4)
    assert (row["tracker_only"], row["reference_only"]) == (1, 2)
    assert row["difference"] == pytest.approx(-0.25)
    assert row["mcnemar_p"] == 1.0


def test_there_are_no_pairs_without_the_reference(make_row):
    assert paired_table([make_row(TrialConfig(tracker="pf"))]) is None


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
    table = blame_table(rows)
    assert table is not None
    (row,) = table.rows
    named = ("tracker", "n", "failures", "tracking", "arm", "unknown")
    assert tuple(row[name] for name in named) == ("igpf", 4, 3, 1, 1, 1)
    assert blame_table([row for row in rows if row.tracker != "oracle"]) is None
    assert blame_table([row for row in rows if row.success]) is None


def test_numbers_have_one_format():
    assert [show_number(value) for value in (None, math.nan, 1.005, 2)] == [
        "-",
        "-",
        "1.00",
        "2.00",
    ]
