"""What the figures show, without looking at them."""

import itertools
from typing import get_args

import numpy as np
import pytest
from toy_trial import trials_of

from experiments.belt.analysis.cells import cell_sizes
from experiments.belt.analysis.curve_figures import shown_speeds, stacked
from experiments.belt.analysis.figures import MOST_SETTINGS, curve_settings
from experiments.belt.analysis.outcome_figure import OUTCOME_STYLES, draw_outcomes
from experiments.belt.analysis.success_figures import draw_matrix, draw_speed
from experiments.belt.config import Outcome, TrialConfig
from experiments.belt.presets import expand
from experiments.report.style import TRACKER_STYLES, file_name, tracker_style


@pytest.fixture
def sweep(make_row):
    """Rows in which `decide(config)` says what succeeds."""

    def make(decide, seeds=range(2), **axes):
        trials = trials_of(expand(**axes), seeds)
        return [make_row(c, success=bool(decide(c))) for c in trials]

    return make


def lightness(colour):
    """From 0 to 1, as a grey print has it (Rec. 601)."""
    red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return 0.299 * red + 0.587 * green + 0.114 * blue


def test_colours_belong_to_trackers():
    assert tracker_style("igpf") == TRACKER_STYLES["igpf"]
    assert tracker_style("mine") == tracker_style("mine")
    colours = [style[0] for style in TRACKER_STYLES.values()]
    assert len(set(colours)) == len(colours)


def test_every_outcome_has_a_look_that_survives_a_grey_print():
    assert list(OUTCOME_STYLES) == list(get_args(Outcome))
    looks = [(round(4 * lightness(colour)), hatch) for colour, hatch in OUTCOME_STYLES.values()]
    assert all(one != other for one, other in itertools.pairwise(looks))


def test_a_bar_is_as_long_as_its_share(make_row):
    rows = [
        make_row(TrialConfig(seed=seed), outcome=outcome, success=outcome == "success")
        for seed, outcome in enumerate(["success", "success", "success", "missed"])
    ]
    (axis,) = draw_outcomes(rows).axes
    assert [bar.get_width() for bar in axis.patches] == [75.0, 25.0]
    assert [bar.get_x() for bar in axis.patches] == [0.0, 75.0]


def test_the_matrix_has_the_easiest_row_above_and_no_number_where_nothing_ran(sweep):
    rows = sweep(
        lambda c: c.condition == "normal" or (c.condition == "dark-2" and c.seed == 0),
        tracker=["igpf", "pf"],
        condition=["dark-3", "normal", "dark-2"],
    )
    rows = [row for row in rows if (row.tracker, row.condition) != ("pf", "dark-3")]
    (axis,) = draw_matrix(rows).axes
    assert [text.get_text() for text in axis.get_yticklabels()] == ["normal", "dark-2", "dark-3"]
    shown = [text.get_text() for text in axis.texts]
    assert shown == ["100", "100", "50", "50", "0"]
    assert draw_matrix(sweep(lambda c: True, speed_mps=[0.1, 0.2])) is None


def test_rates_stand_at_their_speeds_and_the_bound_where_speeds_come_near(sweep):
    slow = draw_speed(sweep(lambda c: c.seed == 0, speed_mps=[0.1, 0.25]))
    (axis,) = slow.axes
    np.testing.assert_allclose(axis.lines[0].get_xydata(), [[0.1, 50.0], [0.25, 50.0]])
    assert axis.get_legend_handles_labels()[1] == ["igpf"]
    fast = draw_speed(sweep(lambda c: True, speed_mps=[0.5, 1.0]))
    assert fast.axes[0].get_legend_handles_labels()[1] == ["igpf", "out of the arm's reach"]
    assert draw_speed(sweep(lambda c: True, speed_mps=[0.5])) is None


def test_curves_that_have_ended_keep_their_last_value():
    errors = stacked([np.array([4.0, 3.0, 2.0, 1.0]), np.array([3.0, 0.5]), np.empty(0)])
    np.testing.assert_array_equal(errors[0], [4.0, 3.0, 2.0, 1.0])
    np.testing.assert_array_equal(errors[1], [3.0, 0.5, 0.5, 0.5])
    assert np.isnan(errors[2]).all()


def test_lowest_and_highest_speed_are_always_shown(sweep):
    rows = sweep(lambda c: True, speed_mps=[0.1 * k for k in range(1, 9)], seeds=[0])
    assert shown_speeds(rows) == pytest.approx([0.1, 0.3, 0.6, 0.8])
    assert shown_speeds(rows[:2]) == pytest.approx([0.1, 0.2])


def test_curves_are_drawn_where_most_trackers_ran(sweep):
    everywhere = sweep(lambda c: True, condition=["normal", "dark-1"], seeds=[0])
    arms = sweep(lambda c: True, tracker=["oracle"], seeds=[0])
    assert list(curve_settings([*everywhere, *arms])) == ["normal"]
    many = sweep(lambda c: True, condition=[f"dark-{k}" for k in range(9)], seeds=[0])
    assert len(curve_settings(many)) == MOST_SETTINGS
    assert curve_settings([]) == {}


def test_names_and_numbers_of_figures(sweep):
    assert (
        file_name("error_curves", "far-side, 0.10 s delay") == "error_curves_far-side_0.10_s_delay"
    )
    rows = sweep(lambda c: True, speed_mps=[0.1, 0.2])
    assert cell_sizes(rows) == "n = 2" and cell_sizes(rows[:3]) == "n = 1 to 2"
