"""Which trials belong together, and what people call them."""

import pytest

from experiments.belt.analysis.cells import SETTING, cell_keys, label, show_key
from experiments.belt.config import TrialConfig
from experiments.report.grouping import group_by


@pytest.mark.parametrize(
    ("field", "values"),
    [("delay_s", (0.0, 0.066)), ("particle_count", (50, 150)), ("camera_rate_hz", (30.0, 60.0))],
)
def test_cells_are_told_apart_by_whatever_else_varies(make_row, field, values):
    rows = [
        make_row(TrialConfig(**{field: value}, seed=seed)) for value in values for seed in (0, 1)
    ]
    keys = cell_keys(rows)
    assert keys == ["tracker", "camera", "condition", field, "speed_mps"]
    assert [len(members) for members in group_by(rows, keys).values()] == [2, 2]
    assert cell_keys(rows[:2]) == ["tracker", "camera", "condition", "speed_mps"]


def test_a_setting_is_all_of_a_trial_that_is_not_the_tracker_s_own():
    assert {"gripper_delay_s", "camera_rate_hz", "motion"} < set(SETTING)
    assert not {"tracker", "seed", "particle_count"} & set(SETTING)


def test_values_have_few_digits_and_their_unit():
    shown = [show_key(value) for value in (0.1, 0.066, 30.0, 150, "normal", 0.0)]
    assert shown == ["0.10", "0.066", "30", "150", "normal", "0"]
    assert label("delay_s", 0.066) == "0.066 s delay"
    assert label("tracker", "igpf") == "igpf"
