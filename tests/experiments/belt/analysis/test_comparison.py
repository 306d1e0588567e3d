"""Two trackers on the same worlds: pairs, verdicts, and what would decide."""

from pathlib import Path

import pytest

from experiments.belt.analysis.comparison import Comparison, compare, pooled, verdict_lines
from experiments.belt.config import TrialConfig
from experiments.belt.presets import expand
from experiments.belt.study import get_study, selection_of, trials
from experiments.study.compare import Side


@pytest.fixture
def folder(make_row):
    """The rows of a folder in which a function of the trial decides, as sides of a comparison."""

    def rows_of(name, cells, decide, seeds=range(20)):
        rows = []
        for job in trials("p", selection_of(cells, seeds)):
            success = decide(job.config)
            outcome = "success" if success else "missed"
            rows.append(make_row(job.config, outcome=outcome, success=success))
        return lambda tracker="": Side.of(Path(name), get_study("belt/p"), rows, tracker)

    return rows_of


def test_pairs_are_worlds_that_both_have_met(folder):
    mine = folder("mine", expand(tracker=["igpf"], speed_mps=[0.1, 0.5]), lambda c: True)
    other = folder("other", expand(tracker=["pf"], speed_mps=[0.5, 1.0]), lambda c: c.seed < 5)
    settings = compare(mine(), other("pf"))
    assert list(settings.values()) == [Comparison(5, 15, 0, 0)]


@pytest.mark.parametrize(
    ("counts", "verdict"),
    [((10, 6, 0, 4), "better"), ((10, 0, 6, 4), "worse"), ((10, 5, 0, 5), "undecided")],
)
def test_six_of_six_decide_and_five_of_five_do_not(counts, verdict):
    """Exact two-sided p of six equal coins is 1/32, of five 1/16."""
    assert Comparison(*counts).verdict == verdict


def test_pooling_adds_the_pairs():
    assert pooled([Comparison(1, 2, 3, 4), Comparison(4, 3, 2, 1)]) == Comparison(5, 5, 5, 5)


def test_the_answer_says_how_many_more_worlds_would_decide(folder):
    both = folder(
        "both", expand(tracker=["igpf", "pf"]), lambda c: c.tracker == "igpf" or c.seed > 3
    )
    first, second = (both(name) for name in ("igpf", "pf"))
    (head, answer) = verdict_lines(first, second)
    assert head.startswith("igpf (both) against pf (both)")
    needed = Comparison(16, 4, 0, 0).worlds_to_decide
    assert "undecided, +20.0 points" in answer
    assert f"some {needed - 20} more worlds would decide" in answer


def test_equals_are_not_decided_by_more_worlds(folder):
    both = folder("both", expand(tracker=["igpf", "pf"]), lambda c: c.seed > 3)
    answer = verdict_lines(both("igpf"), both("pf"))[-1]
    assert "as often better as worse" in answer


def test_folders_that_differ_in_the_world_have_no_pairs(folder):
    mine = folder("mine", expand(TrialConfig(camera_rate_hz=60.0)), lambda c: True)
    other = folder("other", expand(TrialConfig(gripper_delay_s=0.1)), lambda c: True)
    with pytest.raises(ValueError, match="shared of camera_rate_hz, gripper_delay_s"):
        compare(mine(), other())


def test_particles_are_the_tracker_s_own_but_several_counts_are_kept_apart(folder):
    few = folder("few", expand(TrialConfig(particle_count=50)), lambda c: c.seed < 5)
    many = folder("many", expand(particle_count=[150, 300]), lambda c: c.particle_count == 300)
    both = folder("both", expand(particle_count=[50, 300]), lambda c: True)
    other = folder("other", expand(TrialConfig(particle_count=40)), lambda c: True)
    one = compare(few(), other())
    assert list(one.values()) == [Comparison(5, 0, 15, 0)]
    like = compare(many(), both())
    assert [(setting[0], pairs.n) for setting, pairs in like.items()] == [(300, 20)]
    with pytest.raises(ValueError, match="shared of particle_count"):
        compare(many(), few())


def test_each_setting_has_a_line_named_by_what_varies(folder):
    cells = expand(TrialConfig(condition="dark-3"), tracker=["igpf", "pf"], speed_mps=[0.1, 0.5])
    both = folder("both", cells, lambda c: True)
    lines = verdict_lines(both("igpf"), both("pf"))
    assert [line.split(":")[0].strip() for line in lines[1:]] == [
        "0.10 m/s",
        "0.50 m/s",
        "all together",
    ]


def test_what_cannot_be_compared_is_told(folder):
    mine = folder("mine", expand(tracker=["igpf", "pf"], speed_mps=[0.1]), lambda c: True)
    other = folder("other", expand(tracker=["pf"], speed_mps=[0.5]), lambda c: True)
    with pytest.raises(ValueError, match=r"tracker of mine must be one of igpf, pf; say which"):
        mine()
    with pytest.raises(ValueError, match="must be one of igpf, pf; got 'gpf'"):
        mine("gpf")
    with pytest.raises(ValueError, match=r"no world in common; no value is shared of speed_mps$"):
        compare(mine("pf"), other())
