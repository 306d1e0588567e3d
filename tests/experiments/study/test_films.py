"""Videos of jobs: which are made, what survives a kill, and how they are called."""

import time
from dataclasses import replace

import pytest
import toy_study
from toy_study import JOB_COUNT, SELECTION, STUDY, left_by, run_toy

ONE = SELECTION | {"methods": ["pf"]}


def names(folder):
    return {path.name for path in (folder / "videos").iterdir()}


@pytest.mark.parametrize("choice", ["failures", "all"])
def test_a_finished_run_gets_the_videos_that_are_asked_for(copy, unbroken, choice):
    """Odd seeds are failures."""
    done = run_toy(copy, workers=2, video=choice)
    wanted = {
        f"film of {method}, seed {seed}"
        for method in SELECTION["methods"]
        for seed in SELECTION["seeds"]
        if choice == "all" or seed % 2
    }
    assert (done.video_count, done.lost_video_count) == (len(wanted), 0)
    assert {path.read_text() for path in (copy / "videos").iterdir()} == wanted
    assert left_by(copy) == unbroken


def test_without_being_asked_there_are_none(copy):
    assert run_toy(copy).video_count == 0
    assert not (copy / "videos").exists()


def test_only_those_of_the_selection_are_made(copy):
    assert run_toy(copy, ONE | {"seeds": [3]}, video="all").video_count == 1
    assert names(copy) == {"FAIL_done_pf_seed_3_pf_3.mp4"}


def test_only_the_videos_that_lack_are_made(copy):
    run_toy(copy, video="failures")
    whole = names(copy)
    first, *rest = sorted((copy / "videos").iterdir())
    for path in rest:
        path.write_text("mine")
    first.unlink()
    assert run_toy(copy, video="failures").video_count == len(whole)
    assert names(copy) == whole
    assert first.read_text().startswith("film of")
    assert {path.read_text() for path in rest} == {"mine"}


def test_a_kill_while_videos_are_made_leaves_none_by_half(copy):
    process = toy_study.start(copy, 1, video="all", TOY_SLEEP_S="0.1")
    while process.poll() is None and not list(copy.glob("videos/*.mp4")):
        time.sleep(0.005)
    toy_study.kill_group(process)
    assert 0 < len(list(copy.glob("videos/*.mp4"))) < JOB_COUNT
    done = run_toy(copy, video="all")
    assert done.video_count == len(names(copy)) == JOB_COUNT


def test_a_job_that_ends_otherwise_is_no_video_of_its_row(tmp_path, monkeypatch, capsys):
    run_toy(tmp_path, ONE)
    monkeypatch.setenv("TOY_CRASH_SEEDS", "3")
    monkeypatch.setenv("TOY_DEADLY_SEEDS", "2")
    monkeypatch.setenv("TOY_LOSES_FILMS", "1")
    done = run_toy(tmp_path, ONE, workers=1, video="all")
    assert (done.video_count, done.lost_video_count) == (3, 3)
    assert len(names(tmp_path)) == 3
    text = capsys.readouterr().err
    assert text.count("beltgrasp: error: ") == 3
    assert "FAIL_done_pf_seed_1_pf_1.mp4: ended in error when filmed" in text
    assert "_3.mp4: ZeroDivisionError: the toy broke, on purpose\n" in text
    assert "_2.mp4: worker process died 3 times" in text


def test_a_crash_has_a_traceback_and_no_video(tmp_path, monkeypatch):
    monkeypatch.setenv("TOY_CRASH_SEEDS", "3")
    done = run_toy(tmp_path, ONE, video="all")
    assert (done.error_count, done.video_count, done.lost_video_count) == (1, 5, 0)
    assert not any("_3." in name for name in names(tmp_path))


def test_the_name_says_what_is_to_be_seen_and_is_one_of_a_file(tmp_path):
    selection = {"methods": ["my.mod:Tracker/2"], "seeds": [0]}
    run_toy(tmp_path, selection, video="all")
    assert names(tmp_path) == {"PASS_done_my.mod_Tracker_2_seed_0_my.mod.Tracker.2_0.mp4"}


def test_a_study_without_films_refuses_them_before_it_runs(tmp_path):
    with pytest.raises(ValueError, match="toy/sums has no videos; --video must be none"):
        run_toy(tmp_path / "new", study=replace(STUDY, film=""), video="all")
    assert not (tmp_path / "new").exists()
