"""A sweep as a study: which trials it has, how they are called, and what determines their rows."""

import pytest
from toy_trial import make_row

from experiments.belt.config import TrialConfig
from experiments.belt.presets import expand
from experiments.belt.study import SweepTrial, get_study, selection_of, trials
from experiments.study.manifest import jobs_of
from experiments.study.settings import describe

CELLS = expand(tracker=["pf", "igpf"], speed_mps=[0.1])


def test_a_selection_says_where_cells_differ_from_the_defaults():
    selection = selection_of([*CELLS, TrialConfig(seed=7)], (3, 4))
    assert selection["cells"] == [
        {"tracker": "pf", "speed_mps": 0.1},
        {"speed_mps": 0.1},
        {},
    ]
    assert selection["seeds"] == [3, 4]
    jobs = trials("p", selection)
    assert {job.config.camera for job in jobs} == {TrialConfig().camera}


def test_rows_visit_every_cell_before_the_next_seed():
    jobs = jobs_of(get_study("belt/p"), [selection_of(CELLS, (3, 4))], None)
    assert [(job.config.seed, job.config.tracker) for job in jobs] == [
        (3, "pf"),
        (3, "igpf"),
        (4, "pf"),
        (4, "igpf"),
    ]


def test_cells_and_seeds_that_repeat_are_refused():
    for selection in (selection_of([CELLS[0], CELLS[0]], [0]), selection_of(CELLS, [0, 0])):
        with pytest.raises(ValueError, match="preset p: cells and seeds must not repeat"):
            trials("p", selection)


def test_a_trial_is_a_sentence_and_its_row_is_known_before_it_has_run():
    study = get_study("belt/p")
    config = TrialConfig(tracker="my.mod:It", speed_mps=0.5, condition="blur-1+dark-3", seed=7)
    job = SweepTrial("p", config)
    assert study.title(job) == "my.mod:It at 0.5 m/s, blur-1+dark-3, seed 7"
    known, row = study.identity(job), make_row(config, "p")
    assert study.key_of(job) == (config.trial_id,)
    assert all(getattr(row, name) == known[name] for name in known if hasattr(row, name))
    assert {"trial_id", "preset", "tracker", "seed"} <= set(known)


def test_what_is_not_lifted_is_a_failure():
    study = get_study("belt/p")
    for success in (True, False):
        row = make_row(TrialConfig(), success=success)
        assert study.is_failure([row]) is not success
        assert study.score.of(row)[1] == float(success)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("tracker", "pf"),
        ("embodiment", "ur3-soft"),
        ("camera", "overhead"),
        ("condition", "dark-3"),
        ("motion", "sine"),
        ("predictor", "latest"),
    ],
)
def test_everything_that_a_trial_names_is_a_setting_of_it(field, value):
    settings = get_study("belt/p").settings
    standard = describe(settings(SweepTrial("p", TrialConfig())))
    other = describe(settings(SweepTrial("p", TrialConfig(**{field: value}))))
    assert set(other) - set(standard) == {f"{field} {value}"}
    (name,) = set(standard) - set(other)
    assert standard[name] != other[f"{field} {value}"]


def test_the_model_of_an_object_is_a_setting(tmp_path, monkeypatch):
    import sim
    from sim.belt.objects import get_object

    job, name = SweepTrial("p", TrialConfig()), "object box"
    before = describe(get_study("belt/p").settings(job))[name]
    model = get_object("box").xml
    path = tmp_path / model
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes((sim.ASSETS / model).read_bytes() + b"\n")
    monkeypatch.setattr(sim, "ASSETS", tmp_path)
    after = describe(get_study("belt/p").settings(job))[name]
    assert before["model"] != after["model"] and before["spec"] == after["spec"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"tracker": "igfp"}, "tracker must be one of igpf, .*; got 'igfp'; did you mean 'igpf'"),
        ({"tracker": "absent:It"}, "tracker 'absent:It': No module named 'absent'"),
        ({"embodiment": "ur6"}, "embodiment must be one of ur5-rg2, .*; got 'ur6'"),
        ({"camera": "ceiling"}, "camera must be one of far-side, .*; got 'ceiling'"),
        ({"condition": "foggy"}, "condition must be normal, or NAME-LEVEL with a NAME of dark,"),
        ({"condition": "dark-9"}, "condition: dark has levels 0 to 4, got 'dark-9'"),
        ({"object": "ball"}, "object must be one of box, .*; got 'ball'"),
        ({"motion": "zigzag"}, "motion must be one of constant, .*; got 'zigzag'"),
        ({"predictor": "none"}, "predictor must be one of kalman, .*; got 'none'"),
    ],
)
def test_unknown_names_are_refused_with_the_known_ones(changes, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        get_study("belt/p").settings(SweepTrial("p", TrialConfig(**changes)))
