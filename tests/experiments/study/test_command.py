"""Flags, exit codes and closing lines that every command of a study has."""

import dataclasses
import os
from pathlib import Path

import pytest
from toy_study import JOB_COUNT, SELECTION, STUDY, left_by

from experiments.study import command
from experiments.study.command import Plan, StudyCommand, seed_list, split_names, worker_count
from experiments.study.folder import read_results


@dataclasses.dataclass(frozen=True, kw_only=True)
class ToyCommand(StudyCommand):
    """The toy by the flags of every command."""

    name: str = STUDY.name
    needs_rendering: bool = False
    complaints: tuple[str, ...] = ()
    workers: int | None = 1

    def plan(self):
        seeds = SELECTION["seeds"]
        if self.seeds is not None:
            seeds = seed_list(self.seeds, self.first_seed)
        study = dataclasses.replace(STUDY, name=self.name, needs_rendering=self.needs_rendering)
        return Plan(study, SELECTION | {"seeds": seeds}, self.complaints)


def rows_in(folder):
    return read_results(Path(folder), STUDY).rows


def test_names_are_split_at_commas_and_spaces_each_once():
    assert split_names(["pf,gpf", "igpf pf", ""]) == ("pf", "gpf", "igpf")


def test_seeds_begin_where_they_are_told():
    assert seed_list(3, 1000) == [1000, 1001, 1002]
    with pytest.raises(ValueError, match="seeds must be 1 or greater, got 0"):
        seed_list(0)
    with pytest.raises(ValueError, match="first-seed must be 0 or greater, got -1"):
        seed_list(1, -1)


def test_there_is_a_worker_for_each_processor_that_may_be_used():
    assert worker_count(3) == 3
    assert worker_count(None) == len(os.sched_getaffinity(0))


@pytest.mark.parametrize(
    ("name", "shard", "folder"),
    [
        ("belt/loop", None, "out/loop"),
        ("belt/loop", "2/4", "out/loop-shard-2-of-4"),
        ("apple/tables", None, "out/apple-tables"),
        ("bearing-only/circle-pixels", "1/2", "out/bearing-only-circle-pixels-shard-1-of-2"),
        ("video/otb", None, "out/video-otb"),
    ],
)
def test_the_folder_is_named_after_the_study_where_none_is_given(name, shard, folder):
    assert ToyCommand(name=name, shard=shard).folder == Path(folder)
    assert ToyCommand(name=name, shard=shard, out=Path("mine")).folder == Path("mine")


def test_a_run_says_where_things_are(tmp_path, monkeypatch, capsys, unbroken):
    monkeypatch.chdir(tmp_path)
    assert ToyCommand(video="failures").run() == 0
    assert capsys.readouterr().out.splitlines() == [
        f"{JOB_COUNT} sums, {JOB_COUNT // 2} failed: out/toy-sums/rows.csv",
        f"{JOB_COUNT // 2} videos: out/toy-sums/videos",
        "tables and figures: beltgrasp report out/toy-sums",
    ]
    assert left_by(Path("out/toy-sums")) == unbroken


def test_seeds_and_shards_are_those_of_the_flags(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert ToyCommand(seeds=2, first_seed=1000, shard="2/2").run() == 0
    assert "2 sums, 2 failed: out/toy-sums-shard-2-of-2/rows.csv\n" in capsys.readouterr().out
    rows = rows_in("out/toy-sums-shard-2-of-2")
    assert [(row.method, row.seed) for row in rows[::2]] == [("pf", 1001), ("igpf", 1001)]
    assert ToyCommand(seeds=1, shard="1/2").run() == 0
    assert "\n1 sum: " in "\n" + capsys.readouterr().out


def test_a_crash_is_exit_code_1_until_it_is_mended(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("TOY_CRASH_SEEDS", "3")
    assert ToyCommand(out=tmp_path).run() == 1
    assert capsys.readouterr().err.splitlines()[-1] == (
        f"beltgrasp: 2 of them crashed; tracebacks: {tmp_path / 'errors'}; "
        "the same command tries them again"
    )
    monkeypatch.delenv("TOY_CRASH_SEEDS")
    assert ToyCommand(out=tmp_path, retry="none").run() == 1
    assert ToyCommand(out=tmp_path).run() == 0


def test_a_video_that_could_not_be_made_is_exit_code_1(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("TOY_LOSES_FILMS", "3")
    assert ToyCommand(out=tmp_path, video="failures").run() == 1
    assert f"4 videos: {tmp_path / 'videos'}\n" in capsys.readouterr().out
    monkeypatch.delenv("TOY_LOSES_FILMS")
    assert ToyCommand(out=tmp_path, video="failures").run() == 0


def test_what_cannot_be_run_is_a_line_each_and_the_rest_is_run(tmp_path, capsys):
    assert ToyCommand(out=tmp_path, complaints=("no Tow", "bad\nThree")).run() == 1
    captured = capsys.readouterr()
    assert captured.err.startswith("beltgrasp: error: no Tow\nbeltgrasp: error: bad Three\n")
    assert f"{JOB_COUNT} sums" in captured.out


def test_ctrl_c_says_how_to_go_on(tmp_path, monkeypatch, capsys):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("experiments.study.run._running_counts", interrupt)
    assert ToyCommand(out=tmp_path).run() == 130
    assert capsys.readouterr().err.splitlines()[-1] == (
        f"beltgrasp: stopped; 1 of 12 are kept in {tmp_path}; the same command resumes"
    )


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        ({"workers": 0}, "workers must be 1 or greater, got 0"),
        ({"dask": "tcp://x:1", "workers": 2}, "give --workers or --dask"),
        ({"shard": "3/2"}, "shard must be I/N with I from 1 to N, got '3/2'"),
        ({"shard": "half"}, "shard must be I/N with I from 1 to N, as 2/4, got 'half'"),
        ({"shard": "13/13"}, "toy/sums: shard 13/13 has no sum"),
        ({"seeds": 0}, "seeds must be 1 or greater, got 0"),
        ({"seeds": 1, "first_seed": -1}, "first-seed must be 0 or greater, got -1"),
    ],
)
def test_what_does_not_go_together_is_refused_before_anything_is_written(
    tmp_path, monkeypatch, flags, message
):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match=message):
        ToyCommand(**flags).run()
    assert not list(tmp_path.iterdir())


def test_a_scheduler_that_does_not_answer_is_said_before_anything_is_written(tmp_path):
    with pytest.raises(OSError, match="no Dask scheduler answers at nonsense"):
        ToyCommand(out=tmp_path / "new", workers=None, dask="nonsense").run()
    assert not (tmp_path / "new").exists()


def test_a_machine_that_cannot_render_is_refused_where_the_study_needs_it(tmp_path, monkeypatch):
    def refuse():
        raise RuntimeError("no images here")

    monkeypatch.setattr("experiments.study.rendering.gl_renderer", refuse)
    with pytest.raises(RuntimeError, match="no images here"):
        ToyCommand(out=tmp_path / "new", needs_rendering=True).run()
    assert not (tmp_path / "new").exists()
    assert ToyCommand(out=tmp_path / "new").run() == 0


def test_every_command_of_a_study_has_the_same_flags():
    """Those that it narrows keep their names; a user learns them once."""
    from experiments.apple.commands import Approach, Replay, Tables
    from experiments.bearing_only.commands import Circle
    from experiments.belt.commands import Sweep
    from experiments.video.commands import Make, Run

    common = {field.name for field in dataclasses.fields(command.StudyCommand)}
    assert common >= {"out", "seeds", "first_seed", "workers", "shard", "dask", "video", "retry"}
    for kind in (Tables, Replay, Approach, Circle, Sweep, Make, Run):
        assert {field.name for field in dataclasses.fields(kind)} >= common
