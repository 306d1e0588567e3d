"""Two methods on the same tasks."""

import math

import numpy as np
import pytest

from experiments.report.compare import Method, Scale, compare_scores

ERROR = Scale("axis error", "deg")


def compare(first, second, scale=ERROR):
    one, other = (Method(n, dict(enumerate(s))) for n, s in (("A", first), ("B", second)))
    return compare_scores(one, other, scale, np.random.default_rng(0))


def test_the_lines_say_what_was_found():
    head, means, counts, verdict = compare([1.0] * 7 + [3.0, 5.0], [2.0] * 7 + [3.0, 4.5])
    assert head == "A against B, axis error [deg], lower is better, 9 pairs:"
    assert means.startswith("  means: 1.67 and 2.39, difference -0.72 [-")
    low, high = (float(bound) for bound in means.split("[")[1].rstrip("]").split(", "))
    assert -1.0 <= low < -0.72 < high < 0.5
    assert counts == "  A is better in 7, equal in 1, worse in 1; sign test p 0.070"
    assert verdict == "no difference shown"


def test_six_of_six_decide_and_five_of_five_do_not():
    """Exact two-sided p of six equal coins is 1/32, of five 1/16."""
    assert compare([1.0] * 6, [2.0] * 6)[-1] == "A is better"
    assert compare([2.0] * 6, [1.0] * 6)[-1] == "B is better"
    assert compare([1.0] * 5, [2.0] * 5)[-1] == "no difference shown"


def test_higher_scores_are_better_where_the_scale_says_so():
    scale = Scale("overlap", higher_is_better=True, digits=3)
    head, means, counts, verdict = compare([0.5] * 6, [0.25] * 6, scale)
    assert head == "A against B, overlap, higher is better, 6 pairs:"
    assert means == "  means: 0.500 and 0.250, difference +0.250 [+0.250, +0.250]"
    assert counts == "  A is better in 6, equal in 0, worse in 0; sign test p 0.031"
    assert verdict == "A is better"


def test_a_method_that_is_seldom_but_much_worse_is_not_called_better():
    verdict = compare([1.0] * 9 + [90.0], [2.0] * 10)[-1]
    assert verdict == "A is better more often, but not in the mean"


def test_tasks_are_paired_by_their_key_and_unknown_scores_left_out():
    first = Method("A", {"x": 1.0, "y": None, "z": 3.0, "u": math.nan})
    second = Method("B", {"z": 4.0, "y": 2.0, "x": 1.0, "u": 1.0, "w": 9.0})
    head, means, counts, _ = compare_scores(first, second, ERROR, np.random.default_rng(0))
    assert head.endswith("2 pairs:") and "means: 2.00 and 2.50, difference -0.50" in means
    assert counts.startswith("  A is better in 1, equal in 1, worse in 0")


def test_methods_without_a_common_task_are_refused():
    with pytest.raises(ValueError, match="A and B have no axis error of a common task"):
        compare([1.0, None], [None, 2.0])
