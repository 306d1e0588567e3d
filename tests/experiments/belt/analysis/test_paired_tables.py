"""In which cells the reference is better on the same worlds."""

import pytest

from experiments.belt.analysis.paired_tables import condition_table, paired_tables
from experiments.belt.config import TrialConfig


@pytest.fixture
def rows(make_row):
    """Makes rows of a tracker from its successes by seed."""

    def make(tracker, successes, **changes):
        return [
            make_row(TrialConfig(tracker=tracker, seed=seed, **changes), success=success)
            for seed, success in enumerate(successes)
        ]

    return make


def test_pairs_are_matched_by_seed(rows):
    reference = rows("igpf", [True, True, True, False])
    rival = rows("pf", [True, False, False, True, True])
    (row,) = paired_tables([*reference, *rival])["paired"].rows
    assert (row["tracker"], row["n"]) == ("pf", 4)
    assert (row["first_only"], row["second_only"]) == (2, 1)
    assert (row["first_rate"], row["second_rate"]) == (0.75, 0.5)
    assert row["difference"] == pytest.approx(0.25)
    assert (row["mcnemar_p"], row["verdict"]) == (1.0, "undecided")


def test_verdicts_count_cells_and_holm_is_harder_to_please(rows):
    """Six of six decide alone (p 1/32) and not among three cells; twelve of twelve do."""
    results = []
    for condition, wins in (("normal", 0), ("dark-1", 6), ("dark-2", 12)):
        results += rows("igpf", [True] * 12, condition=condition)
        results += rows("pf", [False] * wins + [True] * (12 - wins), condition=condition)
    tables = paired_tables(results)
    assert [row["verdict"] for row in tables["paired"].rows] == ["undecided", "better", "better"]
    assert [row["holm_p"] for row in tables["paired"].rows] == pytest.approx(
        [1.0, 2 / 32, 3 * 2 / 2**12]
    )
    (row,) = tables["verdicts"].rows
    assert [row[k] for k in ("cells", "better", "worse", "undecided")] == [3, 2, 0, 1]
    assert (row["holm_better"], row["holm_worse"]) == (1, 0)
    assert (row["n"], row["first_only"], row["second_only"]) == (36, 18, 0)


def test_there_are_no_pairs_without_the_reference_or_without_common_worlds(rows):
    assert not any(table.rows for table in paired_tables(rows("pf", [True])).values())
    reference, rival = rows("igpf", [True]), rows("pf", [True, True])[1:]
    assert not any(table.rows for table in paired_tables([*reference, *rival]).values())


def test_a_condition_is_held_against_the_normal_one_in_the_same_worlds(rows):
    normal = rows("igpf", [True] * 7, speed_mps=0.1) + rows("igpf", [True], speed_mps=0.5)
    dark = rows("igpf", [False] * 6 + [True], condition="dark-3", speed_mps=0.1)
    alone = rows("pf", [False], condition="dark-3")
    table = condition_table([*normal, *dark, *alone])
    (row,) = table.rows
    assert (row["tracker"], row["condition"], row["n"]) == ("igpf", "dark-3", 7)
    assert (row["first_only"], row["second_only"], row["verdict"]) == (0, 6, "worse")
    assert row["difference"] == pytest.approx(-6 / 7)
    assert not condition_table(normal).rows
