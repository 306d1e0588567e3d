import os
import signal
import time
from dataclasses import replace

import pytest
import toy_sweep
from experiments.belt.films import Scene
from experiments.belt.sweep import run_sweep
from toy_sweep import PRESET, left_by

from experiments.belt.config import TrialConfig, TrialResult
from experiments.study import records
from experiments.study.processes import LocalWorkers


def run(folder, video, workers=1, preset=PRESET):
    return run_sweep(preset, folder, LocalWorkers(workers), video, toy_sweep.TOY)


def names(folder):
    return {path.name for path in (folder / "videos").iterdir()}


@pytest.mark.parametrize("choice", ["failures", "all"])
def test_a_finished_sweep_gets_the_videos_that_are_asked_for(copy, unbroken, choice):
    done = run(copy, choice, workers=2)
    rows = records.read_rows(copy / "trials.csv", TrialResult)
    wanted = [row for row in rows if choice == "all" or not row.success]
    assert 0 < len(wanted) == done.video_count
    assert done.lost_video_count == 0
    videos = {path.read_text() for path in (copy / "videos").iterdir()}
    assert videos == {f"video of {row.trial_id}" for row in wanted}
    assert left_by(copy) == unbroken


def test_without_being_asked_there_are_none(copy):
    assert run(copy, "none").video_count == 0
    assert not (copy / "videos").exists()


def test_only_the_videos_that_lack_are_made(copy):
    run(copy, "failures")
    whole = names(copy)
    first, *rest = sorted((copy / "videos").iterdir())
    for path in rest:
        path.write_text("mine")
    first.unlink()
    run(copy, "failures")
    assert names(copy) == whole
    assert first.read_text().startswith("video of")
    assert {path.read_text() for path in rest} == {"mine"}


def test_a_kill_while_videos_are_made_leaves_none_by_half(copy, toy_environment):
    process = toy_sweep.start(copy, 1, toy_environment, video="all", TOY_SLEEP_S="0.05")
    while process.poll() is None and not list(copy.glob("videos/*.mp4")):
        time.sleep(0.005)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    assert 0 < len(list(copy.glob("videos/*.mp4"))) < len(PRESET.trials)
    done = run(copy, "all")
    assert done.video_count == len(names(copy)) == len(PRESET.trials)


def test_an_attempt_that_ends_otherwise_is_no_video_of_its_row(tmp_path, monkeypatch, capsys):
    column = replace(PRESET, cells=PRESET.cells[:1])
    run(tmp_path, "none", preset=column)
    monkeypatch.setenv("TOY_CRASH_SEEDS", "3")
    monkeypatch.setenv("TOY_DEADLY_SEEDS", "2")
    done = run(tmp_path, "all", preset=column)
    assert (done.video_count, done.lost_video_count) == (2, 2)
    text = capsys.readouterr().err
    assert text.count("beltgrasp: error: ") == 2
    assert "ended in error (ZeroDivisionError: the toy broke, on purpose) when filmed" in text
    assert "worker process died 3 times" in text


def test_the_name_says_what_is_to_be_seen():
    config = TrialConfig(tracker="my.mod:Tracker", speed_mps=0.5, condition="blur-1+dark-3", seed=7)
    assert Scene(config, "missed").file_name == (
        f"FAIL_missed_my.mod.Tracker_0.50mps_blur-1+dark-3_seed7_{config.trial_id}.mp4"
    )
    assert Scene(config, "success").file_name.startswith("PASS_success_my.mod")


def test_a_crash_has_a_traceback_and_no_video():
    assert not Scene(TrialConfig(), "error").is_wanted("all")
