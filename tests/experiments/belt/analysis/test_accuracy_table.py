"""Who sees the target more exactly."""

import pytest

from experiments.belt.analysis.accuracy_table import accuracy_table
from experiments.belt.config import TrialConfig


@pytest.fixture
def rows(make_row):
    """Makes rows of a tracker from its errors by seed."""

    def make(tracker, errors_m, **changes):
        return [
            make_row(TrialConfig(tracker=tracker, seed=seed, **changes), track_rmse_m=error_m)
            for seed, error_m in enumerate(errors_m)
        ]

    return make


def test_worlds_are_paired_and_the_smaller_error_wins(rows):
    table = accuracy_table(
        rows("igpf", [1e-3, 1e-3, 4e-3, 1e-3]) + rows("pf", [4e-3, 4e-3, 1e-3, None, 9e-3])
    )
    (row,) = table.rows
    assert (row["tracker"], row["n"], row["closer"], row["wider"]) == ("pf", 3, 2, 1)
    assert (row["first_rmse_m"], row["second_rmse_m"]) == (1e-3, 4e-3)
    assert row["ratio"] == pytest.approx(4.0 ** (1 / 3))
    assert (row["sign_p"], row["verdict"]) == (1.0, "undecided")


def test_speeds_of_a_condition_count_together_and_conditions_are_one_family(rows):
    results = []
    for speed_mps in (0.1, 0.2):
        results += rows("igpf", [1e-3] * 4, speed_mps=speed_mps)
        results += rows("pf", [2e-3] * 4, speed_mps=speed_mps)
    results += rows("igpf", [1e-3] * 4, condition="dark-1")
    results += rows("pf", [5e-4] * 4, condition="dark-1")
    table = accuracy_table(results)
    normal, dark = table.rows
    assert (normal["n"], normal["sign_p"], normal["verdict"]) == (8, 2 / 2**8, "closer")
    assert normal["holm_p"] == pytest.approx(4 / 2**8)
    assert (dark["n"], dark["sign_p"], dark["verdict"]) == (4, 2 / 2**4, "undecided")
    assert "closer" in table.to_markdown()


def test_who_knows_the_truth_has_no_rival(rows):
    assert not accuracy_table(rows("igpf", [1e-3]) + rows("oracle", [0.0])).rows
    assert not accuracy_table(rows("pf", [1e-3])).rows
