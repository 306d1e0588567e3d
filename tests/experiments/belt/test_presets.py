import pytest

from experiments.belt.config import TrialConfig
from experiments.belt.presets import PRESETS, Preset, expand
from experiments.belt.study import selection_of, trials


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
    small = preset.restricted(["oracle"], [1000, 1001])
    assert {cell.tracker for cell in small.cells} == {"oracle"}
    assert (len(small.cells), small.seeds) == (2, (1000, 1001))


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
    jobs = trials(name, selection_of(preset.cells, preset.seeds))
    assert len(jobs) == len(preset.cells) * len(preset.seeds)
    assert len({job.config.trial_id for job in jobs}) == len(jobs)


def test_the_demo_leaves_time_for_the_set_up():
    """Within two minutes by two workers, at some 6 s a trial with a tracker."""
    demo, smoke = PRESETS["demo"], PRESETS["smoke"]
    assert len(demo.cells) * len(demo.seeds) * 6.0 / 2 <= 120.0
    assert len(smoke.cells) * len(smoke.seeds) == 3
