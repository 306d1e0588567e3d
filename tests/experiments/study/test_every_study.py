"""What holds for every study: whatever happens on the way, the bytes are those of one quiet run.

The studies are real and their selections small; their work is disturbed as that of the toy.
"""

import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import pytest
import toy_study
from toy_sequences import paint_sequence, write_affine
from toy_study import ThisProcess, get_study, left_by

from experiments import studies
from experiments.study.folder import error_path, read_results
from experiments.study.manifest import FILE, Manifest, jobs_of
from experiments.study.merge import merge
from experiments.study.processes import LocalWorkers
from experiments.study.run import Options, run
from experiments.study.settings import describe
from experiments.study.shard import Shard


@dataclass(frozen=True)
class Case:
    """A study, a small selection of it, and another value of a setting, which must be noticed."""

    name: str
    selection: dict[str, Any]
    change: Callable[[pytest.MonkeyPatch, dict[str, Any]], None]
    difference: str
    """What the refusal says of it."""
    shard_count: int = 2


def _other_predictor(patch, _):
    from tracker.belt.prediction import PREDICTORS

    patch.setitem(PREDICTORS, "kalman", replace(PREDICTORS["kalman"], history_count=7))


def _other_box_tracker(patch, _):
    from experiments.video.trackers import VIDEO_TRACKERS

    known = VIDEO_TRACKERS["pf"]
    patch.setitem(VIDEO_TRACKERS, "pf", replace(known, settings={"particle_count": 7}))


def _other_filter(_, selection):
    selection["filter"]["particle_count"] = 60


def _other_controller(patch, _):
    from experiments.bearing_only.controllers import CONTROLLERS

    known = CONTROLLERS["gradient"]
    patch.setitem(CONTROLLERS, "gradient", replace(known, acceleration_std_mps2=2.0))


def _other_methods(patch, _):
    from experiments.apple.methods import METHODS

    patch.setitem(METHODS, "another", METHODS["axial"])


CASES = {
    "belt": Case(
        "belt/trial",
        {"cells": [{"tracker": "oracle", "speed_mps": v} for v in (1.5, 3.0)], "seeds": [0, 1]},
        _other_predictor,
        r"predictor kalman\.history_count was 9, is 7",
    ),
    "video": Case(
        "video/otb",
        {
            "root": "",
            "protocols": ["ope"],
            "trackers": ["pf", "template"],
            "sequences": ["One", "Two"],
            "seeds": [0, 1],
        },
        _other_box_tracker,
        r"tracker pf\.\w+ was .*, is ",
        shard_count=3,
    ),
    "apple": Case(
        "apple/tables",
        {"filter": {"particle_count": 50}, "seeds": [0, 1, 2]},
        _other_filter,
        r"filter\.particle_count was 50, is 60",
        shard_count=3,
    ),
    "bearing-only": Case(
        "bearing-only/circle",
        {
            "controllers": ["gradient", "known-pose"],
            "seeds": [0, 1],
            "changes": {"iteration_count": 30, "landmark_count": 30},
        },
        _other_controller,
        r"controller gradient\.acceleration_std_mps2 was 1\.0, is 2\.0",
    ),
    "apple, rendered": Case(
        "apple/approach",
        {"classes": ["visible"], "aspects": [0.9], "views": ["arc"], "seeds": [1, 2]},
        _other_methods,
        r"methods was \[.*\], is \[.*'another'\]",
    ),
}


@pytest.fixture(
    scope="module",
    params=[
        pytest.param(name, marks=pytest.mark.slow if "rendered" in name else ()) for name in CASES
    ],
)
def case(request, tmp_path_factory):
    """A case, with sequences to track on where it needs them."""
    found = CASES[request.param]
    if "root" not in found.selection:
        return found
    root = tmp_path_factory.mktemp("sequences")
    write_affine(root / "One", paint_sequence(root / "One"))
    paint_sequence(root / "Two", seed=1)
    return replace(found, selection=found.selection | {"root": str(root)})


@pytest.fixture(scope="module")
def finished(case, tmp_path_factory):
    """The folder of a quiet run in this process; not to be written to."""
    folder = tmp_path_factory.mktemp("finished") / "study"
    done = run(get_study(case.name), case.selection, folder, ThisProcess())
    assert done.error_count == 0
    return folder


@pytest.fixture
def unbroken(finished):
    """What a quiet run leaves."""
    return left_by(finished)


def job_count(case):
    return len(jobs_of(get_study(case.name), [case.selection], None))


def test_killed_twice_and_run_again_it_leaves_the_bytes_of_a_quiet_run(case, unbroken, tmp_path):
    for _ in range(2):
        wanted = toy_study.job_count(tmp_path) + 1
        process = toy_study.start(
            tmp_path, 1, name=case.name, selection=case.selection, TOY_SLEEP_S="0.3"
        )
        toy_study.wait_for_jobs(tmp_path, process, wanted)
        toy_study.kill_group(process)
    assert 2 <= toy_study.job_count(tmp_path) < job_count(case)
    run(get_study(case.name), case.selection, tmp_path, LocalWorkers(2))
    assert left_by(tmp_path) == unbroken
    assert len(Manifest.read(tmp_path).sessions) == 3


def test_its_shards_together_are_the_bytes_of_the_whole(case, unbroken, tmp_path):
    """Also where jobs of one cell, which are run at once, come to lie in several shards."""
    study, count = get_study(case.name), case.shard_count
    folders = [tmp_path / str(number) for number in range(1, count + 1)]
    for number, folder in enumerate(folders, start=1):
        run(study, case.selection, folder, ThisProcess(), Options(Shard(number, count)))
    merged = merge(study, folders, tmp_path / "all")
    assert (merged.job_count, merged.missing) == (job_count(case), ())
    assert left_by(tmp_path / "all") == unbroken


@pytest.mark.slow
def test_a_killed_worker_of_a_cluster_changes_no_byte(case, unbroken, cluster, tmp_path):
    address, workers_now = cluster
    process = toy_study.start(tmp_path, address, name=case.name, selection=case.selection)
    toy_study.wait_for_jobs(tmp_path, process, 1)
    toy_study.kill(workers_now()[0])
    _, text = process.communicate(timeout=300)
    assert process.returncode == 0, text
    assert left_by(tmp_path) == unbroken


def test_a_job_that_raises_is_mended_by_the_next_run(case, unbroken, tmp_path, monkeypatch):
    study, selection = get_study(case.name), case.selection
    monkeypatch.setenv("TOY_CRASH_SEEDS", "1")
    done = run(study, selection, tmp_path, ThisProcess())
    crashed = [job for job in jobs_of(study, [selection], None) if toy_study.seed_of(job) == 1]
    assert crashed and done.error_count >= len(crashed)
    assert done.error_count == len({study.key_of(job) for job in crashed}) or study.together
    bad = [row for row in read_results(tmp_path, study).rows if row.outcome == "error"]
    assert {row.detail for row in bad} == {"ZeroDivisionError: the toy broke, on purpose"}
    monkeypatch.delenv("TOY_CRASH_SEEDS")
    assert run(study, selection, tmp_path, ThisProcess()).error_count == 0
    assert left_by(tmp_path) == unbroken
    for job in crashed:
        text = error_path(tmp_path, study.key_of(job)).read_text()
        assert text.startswith("Traceback") and text.endswith("on purpose\n")


def test_other_settings_are_refused_with_what_differs(case, finished, tmp_path, monkeypatch):
    folder = shutil.copytree(finished, tmp_path / "copy")
    before, manifest = left_by(folder), (folder / FILE).read_bytes()
    selection = json.loads(json.dumps(case.selection))
    case.change(monkeypatch, selection)
    with pytest.raises(ValueError, match=f"{case.difference}.*; choose another folder") as refusal:
        run(get_study(case.name), selection, folder, ThisProcess())
    assert str(refusal.value).startswith(f"{folder} holds results with other settings: ")
    assert "\n" not in str(refusal.value)
    assert (left_by(folder), (folder / FILE).read_bytes()) == (before, manifest)


def test_the_rows_are_what_the_study_says(case, finished):
    """Each job has rows under its key, and what is known of it before stands in them."""
    study = get_study(case.name)
    results = read_results(finished, study)
    keys = [tuple(str(getattr(row, name)) for name in study.key) for row in results.rows]
    jobs = jobs_of(study, [case.selection], None)
    assert [*dict.fromkeys(keys)] == [study.key_of(job) for job in jobs]
    assert all(row.outcome != "error" for row in results.rows)
    for job in jobs:
        (row, *_) = (
            r for r, key in zip(results.rows, keys, strict=True) if key == study.key_of(job)
        )
        for name, value in study.identity(job).items():
            if hasattr(row, name):
                assert getattr(row, name) == value, name
        assert study.title(job) and "\n" not in study.title(job)
    scores = [study.score.of(row) for row in results.rows]
    assert any(score is not None for score in scores)


OUTSIDE = """
class Still:
    def __init__(self, rng):
        pass

    def start(self, image, box):
        self.box = box

    def find(self, image):
        return self.box
"""


@pytest.mark.parametrize("subject", ["belt", "video"])
def test_a_tracker_from_outside_that_was_edited_is_noticed(subject, tmp_path, monkeypatch):
    """Its old rows stay, and no new one comes to stand among them."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    name, module = f"still_{subject}:Still", tmp_path / f"still_{subject}.py"
    module.write_text(OUTSIDE)
    if subject == "belt":
        study = replace(studies.get_study("belt/mine"), work="toy_trial:run_trials")
        selection = {"cells": [{"tracker": name}], "seeds": [0]}
    else:
        study, root = studies.get_study("video/otb"), tmp_path / "sequences"
        paint_sequence(root / "One")
        selection = {"root": str(root), "protocols": ["ope"], "trackers": [name]}
        selection |= {"sequences": ["One"], "seeds": [0]}
    folder = tmp_path / "out"
    assert run(study, selection, folder, ThisProcess()).error_count == 0
    assert run(study, selection | {"seeds": [0, 1]}, folder, ThisProcess()).error_count == 0
    before = left_by(folder)
    module.write_text(OUTSIDE.replace("self.box = box", "self.box = box + 1"))
    with pytest.raises(ValueError, match=rf"tracker {name}\.source was \w+, is \w+; choose"):
        run(study, selection | {"seeds": [0, 1, 2]}, folder, ThisProcess())
    assert left_by(folder) == before


class TestSettings:
    """Those of everything that can be run are data, the same in every process."""

    def check(self, study, job):
        text = json.dumps(describe(study.settings(job)))
        assert " at 0x" not in text
        assert text != "{}"

    def test_of_every_preset(self):
        from experiments.belt.presets import PRESETS
        from experiments.belt.study import selection_of

        for name, preset in PRESETS.items():
            study = studies.get_study(f"belt/{name}")
            for job in study.jobs(selection_of(preset.cells, preset.seeds[:1])):
                self.check(study, job)

    def test_of_every_study_of_flights(self):
        from experiments.bearing_only.studies import STUDIES

        for name in STUDIES:
            study = studies.get_study(f"bearing-only/{name}")
            for job in study.jobs({"controllers": [], "seeds": [0]}):
                self.check(study, job)

    def test_of_every_video_tracker(self):
        from experiments.video.trackers import VIDEO_TRACKERS

        for tracker in VIDEO_TRACKERS.values():
            assert " at 0x" not in json.dumps(describe(tracker.settings))

    def test_of_every_rendered_sequence(self):
        from experiments.video.clips import RECIPES

        study = studies.get_study("video/sequences")
        described = set()
        for job in study.jobs({"names": list(RECIPES), "seed": 0}):
            self.check(study, job)
            described.add(json.dumps(describe(study.settings(job)[f"clip {job.name}"])))
        assert len(described) == len(RECIPES)
