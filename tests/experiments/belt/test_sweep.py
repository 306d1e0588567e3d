import json
import os
import signal
import time

import numpy as np
import pytest
import toy_sweep
from experiments.belt.sweep import SweepInterrupted, run_sweep
from experiments.study.results_folder import exclusive
from toy_sweep import LONG_PRESET, PRESET, left_by

from experiments.belt.config import TrialResult, TrialTimings
from experiments.belt.curves import read_curves
from experiments.belt.presets import Preset
from experiments.study import manifest, records
from experiments.study.processes import LocalWorkers


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
    done = run_sweep(PRESET, tmp_path / "two", LocalWorkers(2), run_trial=toy)
    assert left_by(tmp_path / "two") == unbroken
    assert not (tmp_path / "two" / "pending.jsonl").exists()
    assert (tmp_path / "killed_once").exists(), "a worker was to die and be replaced"
    assert (done.trial_count, done.error_count) == (16, 0)
    text = capfd.readouterr().err
    assert (
        "toy: 4 cells x 4 seeds = 16 trials; about 48 s with 2 workers (6 s a trial, assumed)"
        in text
    )
    assert f"success {done.success_count}/16" in text


@pytest.mark.parametrize("workers", [1, 2])
def test_killed_twice_and_run_again_leaves_the_bytes_of_an_unbroken_sweep(
    tmp_path, toy, toy_environment, unbroken, workers
):
    folder = tmp_path / "killed"
    for _ in range(2):
        wanted = max(0, toy_sweep.row_count(folder)) + 3
        process = toy_sweep.start(folder, workers, toy_environment, TOY_SLEEP_S="0.2")
        toy_sweep.wait_for_rows(folder, process, wanted)
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        assert process.returncode == -signal.SIGKILL
    assert 0 < toy_sweep.row_count(folder) < 16
    run_sweep(PRESET, folder, LocalWorkers(workers), run_trial=toy)
    assert left_by(folder) == unbroken
    assert len(json.loads((folder / "manifest.json").read_text())["sessions"]) == 3


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_twenty_kills_of_coordinator_and_workers_change_no_byte(
    tmp_path, toy, toy_environment, long_unbroken, workers
):
    folder = tmp_path / "killed"

    def begin():
        return toy_sweep.start(
            folder, workers, toy_environment, preset=LONG_PRESET, TOY_SLEEP_S="0.1"
        )

    rng = np.random.default_rng(workers)
    kills = toy_sweep.kill_at_random(folder, begin, toy_sweep.children_of, 20, rng)
    assert min(kills) > 0
    assert 0 < toy_sweep.row_count(folder) < len(LONG_PRESET.trials)
    run_sweep(LONG_PRESET, folder, LocalWorkers(workers), run_trial=toy)
    assert left_by(folder) == long_unbroken
    timings = records.read_rows(folder / "timings.csv", TrialTimings)
    assert [row.trial_id for row in timings] == [trial.trial_id for trial in LONG_PRESET.trials]


def test_trials_that_ended_before_their_turn_survive_a_kill(
    tmp_path, toy, toy_environment, unbroken
):
    folder = tmp_path / "killed"
    settings = {"TOY_SLOW_ONCE": str(tmp_path / "slow_once"), "TOY_SLOW_S": "600"}
    process = toy_sweep.start(folder, 2, toy_environment, **settings)
    pending = folder / "pending.jsonl"
    while not records.whole_lines(pending) and process.poll() is None:
        time.sleep(0.005)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    kept = records.whole_lines(pending)
    assert kept
    with pending.open("a") as file:
        file.write('{"index": 15, "tri')
    run_sweep(PRESET, folder, LocalWorkers(2), run_trial=toy)
    assert left_by(folder) == unbroken
    finished = json.loads(kept[0])
    assert finished["timings"] in (folder / "timings.csv").read_text()


@pytest.mark.parametrize("part", [0.0, 0.02, 0.5, 0.999])
def test_a_file_cut_anywhere_resumes_to_the_same_bytes(copy, toy, unbroken, part):
    path = copy / "trials.csv"
    path.write_bytes(path.read_bytes()[: int(part * path.stat().st_size)])
    run_sweep(PRESET, copy, LocalWorkers(1), run_trial=toy)
    assert left_by(copy) == unbroken
    assert toy_sweep.row_count(copy) == len(records.read_rows(copy / "timings.csv", TrialTimings))


def test_a_torn_curve_is_cut_off_and_a_missing_one_is_told(copy, toy, unbroken):
    curves = copy / "curves.csv.gz"
    curves.write_bytes(unbroken["curves.csv.gz"] + unbroken["curves.csv.gz"][:15])
    run_sweep(PRESET, copy, LocalWorkers(1), run_trial=toy)
    assert left_by(copy) == unbroken
    curves.write_bytes(unbroken["curves.csv.gz"][:-5])
    with pytest.raises(ValueError, match=r"curves\.csv\.gz is not that of trials\.csv"):
        run_sweep(PRESET, copy, LocalWorkers(1), run_trial=toy)


def test_curves_are_those_of_the_rows(finished):
    curves = read_curves(finished / "curves.csv.gz")
    assert list(curves) == [trial.trial_id for trial in PRESET.trials]


def test_a_finished_sweep_runs_nothing_again(copy, toy, unbroken, monkeypatch):
    monkeypatch.setenv("TOY_CRASH_SEEDS", "0,1,2,3")
    done = run_sweep(PRESET, copy, LocalWorkers(2), run_trial=toy)
    assert done.error_count == 0
    assert left_by(copy) == unbroken


def test_a_crash_is_a_row_and_its_traceback_is_kept(tmp_path, toy, monkeypatch):
    monkeypatch.setenv("TOY_CRASH_SEEDS", "2")
    monkeypatch.setenv("TOY_DEADLY_SEEDS", "3")
    preset = Preset("toy", "", PRESET.cells[:1], tuple(range(5)))
    done = run_sweep(preset, tmp_path / "out", LocalWorkers(2), run_trial=toy)
    rows = records.read_rows(done.trials_path, TrialResult)
    assert [row.outcome == "error" for row in rows] == [False, False, True, True, False]
    assert done.error_count == 2
    assert rows[2].detail == "ZeroDivisionError: the toy broke, on purpose"
    text = (tmp_path / "out" / "errors" / f"{rows[2].trial_id}.txt").read_text()
    assert text.startswith("Traceback (most recent call last)")
    assert "ZeroDivisionError: the toy broke" in text
    assert rows[3].detail == "worker process died 3 times, the last time by SIGKILL"


def test_ctrl_c_keeps_what_is_finished(tmp_path, toy, unbroken, monkeypatch):
    folder = tmp_path / "stopped"

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("experiments.belt.sweep._running_counts", interrupt)
    with pytest.raises(SweepInterrupted, match="stopped; 1 of 16 trials are kept in"):
        run_sweep(PRESET, folder, LocalWorkers(1), run_trial=toy)
    monkeypatch.undo()
    run_sweep(PRESET, folder, LocalWorkers(1), run_trial=toy)
    assert left_by(folder) == unbroken


def test_a_folder_of_another_preset_is_refused_and_left_alone(copy, toy, unbroken):
    other = Preset("other", "", PRESET.cells, PRESET.seeds)
    with pytest.raises(ValueError, match="holds results of preset 'toy', not of 'other'"):
        run_sweep(other, copy, LocalWorkers(1), run_trial=toy)
    longer = Preset("toy", "", PRESET.cells, (*PRESET.seeds, 9))
    with pytest.raises(ValueError, match="another version of preset 'toy'"):
        run_sweep(longer, copy, LocalWorkers(1), run_trial=toy)
    assert left_by(copy) == unbroken


def test_foreign_results_are_not_adopted(tmp_path, toy):
    (tmp_path / "trials.csv").write_text("mine\n")
    with pytest.raises(ValueError, match=r"holds a trials.csv without its manifest.json"):
        run_sweep(PRESET, tmp_path, LocalWorkers(1), run_trial=toy)
    assert (tmp_path / "trials.csv").read_text() == "mine\n"


def test_two_sweeps_do_not_share_a_folder(tmp_path, toy):
    with (
        exclusive(tmp_path / "out"),
        pytest.raises(ValueError, match="another sweep is writing to"),
    ):
        run_sweep(PRESET, tmp_path / "out", LocalWorkers(1), run_trial=toy)


def test_no_workers_are_refused():
    with pytest.raises(ValueError, match="workers must be 1 or greater, got 0"):
        LocalWorkers(0)


def test_the_manifest_says_what_ran_where(finished):
    content = manifest.read_manifest(finished)
    assert content["preset"] == "toy"
    assert content["trial_count"] == 16
    assert content["gl_renderers"] == ["toy"]
    (session,) = content["sessions"]
    assert session["workers"] == 1
    assert session["packages"]["mujoco"].startswith("3.")
    assert {"commit", "is_dirty", "command", "python", "platform", "cpu"} <= set(session)
