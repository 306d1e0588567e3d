import json
import os
import shutil
import signal
import subprocess
import time

import pytest

from experiments import manifest, records
from experiments.config import TrialResult, TrialTimings
from experiments.curves import read_curves
from experiments.presets import Preset, expand
from experiments.results_folder import exclusive
from experiments.sweep import SweepInterrupted, run_sweep

PRESET = Preset("toy", "", expand(tracker=["pf", "igpf"], speed_mps=[0.1, 0.5]), tuple(range(4)))

COMMAND = """
import sys
from pathlib import Path
from experiments.presets import Preset, expand
from experiments.sweep import run_sweep
cells = expand(tracker=["pf", "igpf"], speed_mps=[0.1, 0.5])
preset = Preset("toy", "", cells, tuple(range(4)))
run_sweep(preset, Path(sys.argv[1]), int(sys.argv[2]), "toy_trial:run_trial")
"""


def left_by(folder):
    """What does not depend on how a sweep ran."""
    return {name: (folder / name).read_bytes() for name in ("trials.csv", "curves.csv.gz")}


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """Folder of an unbroken sweep by one worker; not to be written to."""
    folder = tmp_path_factory.mktemp("finished") / "toy"
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(os.path.dirname(__file__))
        run_sweep(PRESET, folder, 1, "toy_trial:run_trial")
    return folder


@pytest.fixture
def unbroken(finished):
    """Bytes of the rows and curves of an unbroken sweep by one worker."""
    return left_by(finished)


@pytest.fixture
def copy(finished, tmp_path):
    """A copy of the unbroken sweep to do harm to."""
    return shutil.copytree(finished, tmp_path / "copy")


def start(folder, workers, environment, **toy_settings):
    """The sweep in a process of its own, as the leader of a group that can be killed."""
    return subprocess.Popen(
        [environment["PYTHON"], "-c", COMMAND, str(folder), str(workers)],
        env=environment | toy_settings,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )


def row_count(folder):
    path = folder / "trials.csv"
    return path.read_bytes().count(b"\n") - 1 if path.exists() else -1


def wait_for_rows(folder, process, count):
    while row_count(folder) < count and process.poll() is None:
        time.sleep(0.005)


def test_a_sweep_has_one_row_for_each_trial_in_order(finished):
    rows = records.read_rows(finished / "trials.csv", TrialResult)
    assert [row.trial_id for row in rows] == [trial.trial_id for trial in PRESET.trials]
    assert {row.preset for row in rows} == {"toy"}
    timings = records.read_rows(finished / "timings.csv", TrialTimings)
    assert [row.trial_id for row in timings] == [row.trial_id for row in rows]


def test_two_workers_leave_the_bytes_of_one_even_out_of_order(
    tmp_path, toy, unbroken, monkeypatch, capfd
):
    monkeypatch.setenv("TOY_SLOW_ONCE", str(tmp_path / "slow_once"))
    monkeypatch.setenv("TOY_SLOW_S", "0.5")
    monkeypatch.setenv("TOY_KILL_ONCE", str(tmp_path / "killed_once"))
    done = run_sweep(PRESET, tmp_path / "two", 2, toy)
    assert left_by(tmp_path / "two") == unbroken
    assert not (tmp_path / "two" / "pending.jsonl").exists()
    assert (tmp_path / "killed_once").exists(), "a worker was to die and be replaced"
    assert (done.trial_count, done.error_count) == (16, 0)
    text = capfd.readouterr().err
    assert "toy: 4 cells x 4 seeds = 16 trials; about 00:48 (min:s) with 2 workers" in text
    assert f"success {done.success_count}/16" in text


@pytest.mark.parametrize("workers", [1, 2])
def test_killed_twice_and_run_again_leaves_the_bytes_of_an_unbroken_sweep(
    tmp_path, toy, toy_environment, unbroken, workers
):
    folder = tmp_path / "killed"
    for rows_before_the_kill in (3, 9):
        process = start(folder, workers, toy_environment, TOY_SLEEP_S="0.03")
        wait_for_rows(folder, process, rows_before_the_kill)
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        assert process.returncode == -signal.SIGKILL
    assert 0 < row_count(folder) < 16
    run_sweep(PRESET, folder, workers, toy)
    assert left_by(folder) == unbroken
    assert len(json.loads((folder / "manifest.json").read_text())["sessions"]) == 3


def test_trials_that_ended_before_their_turn_survive_a_kill(
    tmp_path, toy, toy_environment, unbroken
):
    folder = tmp_path / "killed"
    settings = {"TOY_SLOW_ONCE": str(tmp_path / "slow_once"), "TOY_SLOW_S": "600"}
    process = start(folder, 2, toy_environment, **settings)
    pending = folder / "pending.jsonl"
    while not records.whole_lines(pending) and process.poll() is None:
        time.sleep(0.005)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    kept = records.whole_lines(pending)
    assert kept
    with pending.open("a") as file:
        file.write('{"index": 15, "tri')
    run_sweep(PRESET, folder, 2, toy)
    assert left_by(folder) == unbroken
    finished = json.loads(kept[0])
    assert finished["timings"] in (folder / "timings.csv").read_text()


@pytest.mark.parametrize("part", [0.0, 0.02, 0.5, 0.999])
def test_a_file_cut_anywhere_resumes_to_the_same_bytes(copy, toy, unbroken, part):
    path = copy / "trials.csv"
    path.write_bytes(path.read_bytes()[: int(part * path.stat().st_size)])
    run_sweep(PRESET, copy, 1, toy)
    assert left_by(copy) == unbroken
    assert row_count(copy) == len(records.read_rows(copy / "timings.csv", TrialTimings))


def test_a_torn_curve_is_cut_off_and_a_missing_one_is_told(copy, toy, unbroken):
    curves = copy / "curves.csv.gz"
    curves.write_bytes(unbroken["curves.csv.gz"] + unbroken["curves.csv.gz"][:15])
    run_sweep(PRESET, copy, 1, toy)
    assert left_by(copy) == unbroken
    curves.write_bytes(unbroken["curves.csv.gz"][:-5])
    with pytest.raises(ValueError, match=r"curves\.csv\.gz is not that of trials\.csv"):
        run_sweep(PRESET, copy, 1, toy)


def test_curves_are_those_of_the_rows(finished):
    curves = read_curves(finished / "curves.csv.gz")
    assert list(curves) == [trial.trial_id for trial in PRESET.trials]


def test_a_finished_sweep_runs_nothing_again(copy, toy, unbroken, monkeypatch):
    monkeypatch.setenv("TOY_CRASH_SEEDS", "0,1,2,3")
    done = run_sweep(PRESET, copy, 2, toy)
    assert done.error_count == 0
    assert left_by(copy) == unbroken


def test_a_crash_is_a_row_and_its_traceback_is_kept(tmp_path, toy, monkeypatch):
    monkeypatch.setenv("TOY_CRASH_SEEDS", "2")
    monkeypatch.setenv("TOY_DEADLY_SEEDS", "3")
    preset = Preset("toy", "", PRESET.cells[:1], tuple(range(5)))
    done = run_sweep(preset, tmp_path / "out", 2, toy)
    rows = records.read_rows(done.trials_path, TrialResult)
    assert [row.outcome == "error" for row in rows] == [False, False, True, True, False]
    assert done.error_count == 2
    assert rows[2].detail == "ZeroDivisionError: the toy broke, on purpose"
    text = (tmp_path / "out" / "errors" / f"{rows[2].trial_id}.txt").read_text()
    assert text.startswith("Traceback (most recent call last)")
    assert "ZeroDivisionError: the toy broke" in text
    assert rows[3].detail == "worker process died 2 times, the last time by SIGKILL"


def test_ctrl_c_keeps_what_is_finished(tmp_path, toy, unbroken, monkeypatch):
    folder = tmp_path / "stopped"

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("experiments.sweep._running_counts", interrupt)
    with pytest.raises(SweepInterrupted, match="stopped; 1 of 16 trials are kept in"):
        run_sweep(PRESET, folder, 1, toy)
    monkeypatch.undo()
    monkeypatch.syspath_prepend(os.path.dirname(__file__))
    run_sweep(PRESET, folder, 1, toy)
    assert left_by(folder) == unbroken


def test_a_folder_of_another_preset_is_refused_and_left_alone(copy, toy, unbroken):
    other = Preset("other", "", PRESET.cells, PRESET.seeds)
    with pytest.raises(ValueError, match="holds results of preset 'toy', not of 'other'"):
        run_sweep(other, copy, 1, toy)
    longer = Preset("toy", "", PRESET.cells, (*PRESET.seeds, 9))
    with pytest.raises(ValueError, match="another version of preset 'toy'"):
        run_sweep(longer, copy, 1, toy)
    assert left_by(copy) == unbroken


def test_foreign_results_are_not_adopted(tmp_path, toy):
    (tmp_path / "trials.csv").write_text("mine\n")
    with pytest.raises(ValueError, match=r"holds a trials.csv without its manifest.json"):
        run_sweep(PRESET, tmp_path, 1, toy)
    assert (tmp_path / "trials.csv").read_text() == "mine\n"


def test_two_sweeps_do_not_share_a_folder(tmp_path, toy):
    with (
        exclusive(tmp_path / "out"),
        pytest.raises(ValueError, match="another sweep is writing to"),
    ):
        run_sweep(PRESET, tmp_path / "out", 1, toy)


def test_no_workers_are_refused(tmp_path, toy):
    with pytest.raises(ValueError, match="workers must be 1 or greater, got 0"):
        run_sweep(PRESET, tmp_path / "out", 0, toy)


def test_the_manifest_says_what_ran_where(finished):
    content = manifest.read_manifest(finished)
    assert content["preset"] == "toy"
    assert content["trial_count"] == 16
    assert content["gl_renderers"] == ["toy"]
    (session,) = content["sessions"]
    assert session["workers"] == 1
    assert session["packages"]["mujoco"].startswith("3.")
    assert {"commit", "is_dirty", "command", "python", "platform", "cpu"} <= set(session)
