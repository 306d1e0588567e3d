"""The command line: what it prints, its exit codes, and the one line that a mistake gets."""

import json
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from toy_study import left_by
from toy_trial import trials_of

from experiments import catalogue, cli
from experiments.belt import presets, study
from experiments.belt.presets import Preset, expand

CELLS = expand(tracker=["pf", "igpf"], speed_mps=[0.1, 1.2])


@pytest.fixture
def toy(monkeypatch):
    """The command line on the toy trial, and no rendering."""
    known = study.get_study

    def get_study(name):
        work, film = "toy_trial:run_trials", "toy_trial:film_trial"
        return replace(known(name), work=work, film=film)

    monkeypatch.setattr(study, "get_study", get_study)
    monkeypatch.setattr("experiments.study.rendering.gl_renderer", lambda: "toy")


def complain(capsys, *arguments):
    """The one line and nothing else that a faulty command line gets."""
    assert cli.run(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert captured.err.startswith("beltgrasp: error: ")
    return captured.err.removeprefix("beltgrasp: error: ").strip()


def test_help_names_every_command(capsys):
    assert cli.run(["--help"]) == 0
    text = capsys.readouterr().out
    for command in ("trial", "sweep", "merge", "report", "compare", "list", "view", "otb"):
        assert f"• {command}" in text


def test_the_version_is_that_of_package_and_code(capsys):
    assert cli.run(["--version"]) == 0
    assert re.fullmatch(r"beltgrasp \d+\.\d+\.\d+, commit \S+\n", capsys.readouterr().out)


def test_help_needs_no_heavy_import(toy_environment):
    code = (
        "import sys; from experiments import cli; "
        "commands = ['otb', 'run'], ['sweep'], ['merge'], ['trial']; "
        "code = any(cli.run([*words, '--help']) for words in commands); "
        "heavy = {'distributed', 'numpy', 'mujoco', 'dm_control', 'cv2', 'matplotlib', 'tracker'}; "
        "heavy &= set(sys.modules); "
        "sys.exit(f'imported {heavy}' if heavy else code)"
    )
    command = [toy_environment["PYTHON"], "-c", code]
    done = subprocess.run(command, env=toy_environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    for flag in (
        "--tracker --speed-mps --seed --camera --condition --object --motion --predictor --delay-s "
        "--camera-rate-hz --particle-count --video --json"
    ).split():
        assert f"{flag} " in done.stdout


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ("trial --speed-mps -1", "speed_mps must be a number from 0 to 3, got -1.0"),
        ("trial --speed-mps nan", "speed_mps must be a number from 0 to 3, got nan"),
        ("trial --delay-s 40", "delay_s must be a number from 0 to 1, got 40.0"),
        ("trial --particle-count 0", "particle_count must be 1 or greater, got 0"),
        ("trial --seed x", "Error parsing --seed: invalid literal for int() with base 10: 'x'"),
        ("trial --sped-mps 1", "Unrecognized options: --sped-mps, 1; did you mean --speed-mps?"),
        ("trial --tracker igfp", "tracker must be one of igpf, gpf, pf,"),
        ("trial --camera ceiling", "camera must be one of far-side,"),
        (
            "sweep lop",
            "preset must be one of demo, smoke, loop, predictors, paper, real-cell, speed, stress,",
        ),
        ("sweep demo --seeds 0", "seeds must be 1 or greater, got 0"),
        ("sweep demo --first-seed -1", "first-seed must be 0 or greater, got -1"),
        ("sweep demo --trackers igfp", "tracker must be one of igpf, gpf, pf,"),
        ("trial --tracker absent:It", "tracker 'absent:It': No module named 'absent'"),
        ("sweep demo --shard 4/3", "shard must be I/N with I from 1 to N, got '4/3'"),
        ("sweep demo --shard half", "shard must be I/N with I from 1 to N, as 2/4, got 'half'"),
        ("sweep demo --shard 10/10", "belt/demo: shard 10/10 has no trial"),
        ("sweep demo --dask nonsense", "no Dask scheduler answers at nonsense"),
        ("sweep demo --dask a:1 --workers 2", "workers are those of the Dask scheduler"),
        (
            "sweep demo --video some",
            "invalid choice 'some' for argument '--video'. Expected one of",
        ),
        ("sweep demo --retry all", "invalid choice 'all' for argument '--retry'. Expected one of"),
        ("merge nowhere --out all", "nowhere holds no results: it has no manifest.json"),
        ("merge --out all", "merge needs the folder of one shard at least"),
        ("sweep demo --workers 0", "workers must be 1 or greater, got 0"),
        ("sweep", "Missing from beltgrasp sweep: PRESET Name of the preset"),
        ("swep demo", "Unrecognized options: swep, demo; Available subcommands: trial, sweep"),
        (
            "compar a",
            "Unrecognized options: compar, a; Available subcommands: trial, sweep, merge, report, "
            "compare, list, view, otb, apple, bearing-only; did you mean compare?",
        ),
        (
            "bearing-only lin",
            "Unrecognized options: lin; Available subcommands: line, circle, speed, localisation, "
            "robot; did you mean line?",
        ),
        (
            "",
            "Expected one of {trial, sweep, merge, report, compare, list, view, otb, apple, "
            "bearing-only}.",
        ),
        ("report nowhere", "nowhere holds no results: it has no manifest.json"),
        ("compare nowhere:igpf there", "nowhere holds no results: it has no manifest.json"),
        ("apple report out", "Unrecognized options:"),
        ("bearing-only report out", "Unrecognized options:"),
        ("otb report out", "Unrecognized options:"),
    ],
)
def test_what_the_user_got_wrong_is_one_line(
    capsys, toy, tmp_path, monkeypatch, arguments, expected
):
    monkeypatch.chdir(tmp_path)
    assert complain(capsys, *arguments.split()).startswith(expected)
    assert not [path for path in tmp_path.rglob("*") if path.suffix in (".csv", ".json")]


def test_view_without_a_display_is_one_line(capsys, monkeypatch):
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert complain(capsys, "view").startswith("view needs a display")


def test_list_has_a_line_for_each_name(capsys, monkeypatch):
    names = {"trackers": {"igpf": "the filter"}, "control arms": {"oracle-noisy": "the truth"}}
    monkeypatch.setattr(catalogue, "catalogue", lambda: names)
    assert cli.run(["list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines == [
        "trackers:",
        "  igpf          the filter",
        "control arms:",
        "  oracle-noisy  the truth",
    ]


def test_a_trial_prints_a_summary_or_its_row(capsys, toy):
    assert cli.run(["trial", "--speed-mps", "0.1", "--seed", "3"]) == 0
    assert "igpf at 0.1 m/s, seed 3" in capsys.readouterr().out
    rows = []
    for _ in range(2):
        assert cli.run(["trial", "--speed-mps", "0.1", "--seed", "3", "--json"]) == 0
        rows.append(json.loads(capsys.readouterr().out))
    assert rows[0] == rows[1]
    assert (rows[0]["preset"], rows[0]["seed"]) == ("trial", 3)


def test_a_trial_that_crashes_is_a_row_and_exit_code_1(capsys, toy, monkeypatch):
    monkeypatch.setenv("TOY_CRASH_SEEDS", "3")
    assert cli.run(["trial", "--seed", "3", "--json"]) == 1
    captured = capsys.readouterr()
    assert json.loads(captured.out)["outcome"] == "error"
    assert captured.err.startswith("Traceback")


def test_trials_are_kept_in_a_folder_where_one_is_given(capsys, toy, tmp_path):
    folder = tmp_path / "mine"
    for seed in ("3", "1", "3"):
        assert cli.run(["trial", "--seed", seed, "--out", str(folder)]) == 0
    lines = (folder / "rows.csv").read_text().splitlines()
    seeds = [line.split(",")[lines[0].split(",").index("seed")] for line in lines[1:]]
    assert seeds == ["1", "3"]
    capsys.readouterr()
    assert cli.run(["report", str(folder)]) == 0
    assert "igpf" in capsys.readouterr().out
    assert complain(capsys, "sweep", "demo", "--out", str(folder)).startswith(
        f"{folder} holds results of belt/trial, not of belt/demo; choose another folder"
    )


def test_a_trial_is_filmed_into_a_file(capsys, toy, tmp_path):
    path = tmp_path / "new" / "film.mp4"
    assert cli.run(["trial", "--video", str(path)]) == 0
    assert f"video: {path}\n" in capsys.readouterr().out
    assert path.read_text().startswith("video of")


@pytest.fixture
def mini(monkeypatch, tmp_path):
    """A small preset, in an empty working folder."""
    monkeypatch.setitem(presets.PRESETS, "mini", Preset("mini", "", CELLS, (0, 1)))
    monkeypatch.chdir(tmp_path)


def test_sweep_report_and_compare_end_to_end(capsys, toy, mini, monkeypatch):
    assert cli.run(["sweep", "mini", "--workers", "1"]) == 0
    output = capsys.readouterr().out
    assert output.startswith("8 trials, ") and " failed: out/mini/rows.csv\n" in output
    assert cli.run(["report", "out/mini"]) == 0
    assert "written: out/mini/figures/outcomes.png" in capsys.readouterr().out
    assert cli.run(["compare", "out/mini:pf", "out/mini:igpf"]) == 0
    assert capsys.readouterr().out.startswith("pf (out/mini) against igpf (out/mini), success")
    assert complain(capsys, "compare", "out/mini", "out/mini:pf") == (
        "tracker of out/mini must be one of pf, igpf; say which: DIR:TRACKER"
    )
    monkeypatch.setenv("TOY_CRASH_SEEDS", "1")
    assert cli.run(["sweep", "mini", "--out", "crashed", "--workers", "1"]) == 1
    assert "4 of them crashed; tracebacks: crashed/errors" in capsys.readouterr().err
    assert complain(capsys, "sweep", "demo", "--out", "out/mini").startswith(
        "out/mini holds results of belt/mini, not of belt/demo"
    )


def test_a_sweep_takes_trackers_and_seeds_of_its_flags(capsys, toy, mini):
    flags = ["--seeds", "2", "--first-seed", "1000", "--trackers", "igpf", "--workers", "1"]
    assert cli.run(["sweep", "mini", *flags]) == 0
    lines = Path("out/mini/rows.csv").read_text().splitlines()
    ids = [config.trial_id for config in trials_of(CELLS[2:], (1000, 1001))]
    assert [line.partition(",")[0] for line in lines[1:]] == ids


def test_shards_are_merged_to_the_whole(capsys, toy, mini):
    flags = ["--workers", "1", "--seeds", "2", "--trackers", "pf"]
    assert cli.run(["sweep", "mini", *flags, "--out", "whole"]) == 0
    assert cli.run(["sweep", "mini", *flags, "--shard", "1/2"]) == 0
    assert "belt/mini: 2 trials; 1 worker" in capsys.readouterr().err
    assert cli.run(["merge", "out/mini-shard-1-of-2", "--out", "all"]) == 0
    captured = capsys.readouterr()
    assert captured.out == "2 jobs: all/rows.csv\n"
    assert "warning: shard 2/2 lacks 2 of 2 trials: " in captured.err
    assert cli.run(["sweep", "mini", *flags, "--shard", "2/2", "--video", "all"]) == 0
    assert "2 videos: out/mini-shard-2-of-2/videos" in capsys.readouterr().out
    assert cli.run(["merge", "out/mini-shard-1-of-2", "out/mini-shard-2-of-2", "--out", "all"]) == 0
    assert capsys.readouterr().out == (
        "4 jobs: all/rows.csv\ntables and figures: beltgrasp report all\n"
    )
    assert left_by(Path("all")) == left_by(Path("whole"))
