"""In which cells the reference is better on the same worlds."""

import pytest

from experiments.config import TrialConfig
from experiments.paired_tables import paired_tables, show_p


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
    assert (row["reference_only"], row["rival_only"]) == (2, 1)
    assert (row["reference_rate"], row["rival_rate"]) == (0.75, 0.5)
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
    assert (row["n"], row["reference_only"], row["rival_only"]) == (36, 18, 0)


def test_there_are_no_pairs_without_the_reference_or_without_common_worlds(rows):
    assert paired_tables(rows("pf", [True])) == {}
    reference, rival = rows("igpf", [True]), rows("pf", [True, True])[1:]
    assert paired_tables([*reference, *rival]) == {}


def test_small_p_has_a_bound():
    assert [show_p(p) for p in (0.0004, 0.0316, 1.0)] == ["< 0.001", "0.032", "1.000"]
