import pytest
from experiments.belt.sweep import ASSUMED_TRIAL_S

from experiments.belt.config import TrialConfig
from experiments.belt.presets import PRESETS, Preset, expand


def test_axes_expand_to_their_product():
    cells = expand(TrialConfig(delay_s=0.1), tracker=["pf", "igpf"], speed_mps=[0.1, 0.25])
    assert [(cell.tracker, cell.speed_mps) for cell in cells] == [
        ("pf", 0.1),
        ("pf", 0.25),
        ("igpf", 0.1),
        ("igpf", 0.25),
    ]
    assert all(cell.delay_s == 0.1 for cell in cells)


def test_an_impossible_cell_is_refused_where_it_is_written():
    with pytest.raises(ValueError, match="speed_mps must be a number from 0 to 3, got -1"):
        expand(speed_mps=[-1.0])


def test_trials_visit_every_cell_before_the_next_seed():
    preset = Preset("p", "", expand(tracker=["pf", "igpf"]), (3, 4))
    assert [(trial.seed, trial.tracker) for trial in preset.trials] == [
        (3, "pf"),
        (3, "igpf"),
        (4, "pf"),
        (4, "igpf"),
    ]


@pytest.mark.parametrize(
    ("cells", "seeds"),
    [((), (0,)), (expand(), ()), (expand(), (0, 0)), (expand(tracker=["pf", "pf"]), (0,))],
)
def test_empty_and_repeated_axes_are_refused(cells, seeds):
    with pytest.raises(ValueError, match="preset p: cells and seeds must not"):
        Preset("p", "", cells, seeds)


def test_a_preset_is_restricted_to_trackers_and_seeds():
    preset = Preset("p", "", expand(tracker=["igpf", "oracle"], speed_mps=[0.1, 0.5]), (0, 1, 2))
    assert preset.restricted() == preset
    small = preset.restricted(["oracle"], 2)
    assert {(t.tracker, t.seed) for t in small.trials} == {("oracle", 0), ("oracle", 1)}


def test_a_new_tracker_takes_the_cells_of_the_first():
    cells = expand(tracker=["igpf"], speed_mps=[0.1, 0.5]) + expand(tracker=["oracle"])
    own = Preset("p", "", cells, (0,)).restricted(["my.own:Tracker", "oracle"])
    assert [(c.tracker, c.speed_mps) for c in own.cells] == [
        ("my.own:Tracker", 0.1),
        ("my.own:Tracker", 0.5),
        ("oracle", 0.25),
    ]


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_has_its_name_and_distinct_trials(name):
    preset = PRESETS[name]
    assert preset.name == name
    assert len({trial.trial_id for trial in preset.trials}) == len(preset.trials)


def test_the_demo_leaves_time_for_the_set_up():
    assert len(PRESETS["demo"].trials) * ASSUMED_TRIAL_S / 2 <= 120.0
    assert len(PRESETS["smoke"].trials) == 3
