import json
import sys
import types
from pathlib import Path

import pytest
import toy_sweep

from experiments import catalogue, cli
from experiments.belt import presets
from experiments.belt.presets import Preset, expand


@pytest.fixture
def registries(monkeypatch):
    """Small registries and no rendering, so that no simulator is imported."""
    names = {
        "trackers": {"igpf": "the filter", "pf": "the other"},
        "control arms": {"oracle": "the truth"},
        "peers": {"csrt": "a rival"},
        "embodiments": {"ur5-rg2": "an arm"},
        "cameras": {"far-side": "a camera"},
        "objects": {"box": "a carton"},
        "motions": {"constant": "one speed"},
        "conditions": {"normal": "light"},
        "predictors": {"kalman": "a filter"},
        "presets": {"demo": "a look"},
    }
    monkeypatch.setattr(catalogue, "catalogue", lambda: names)
    rendering = types.ModuleType("experiments.belt.rendering")
    monkeypatch.setitem(rendering.__dict__, "gl_renderer", lambda: "toy")
    monkeypatch.setitem(sys.modules, "experiments.belt.rendering", rendering)


@pytest.fixture
def toy_trial(toy, registries, monkeypatch):
    """The command line on the toy trial."""
    monkeypatch.setattr("experiments.study.workers.RUN_TRIAL", toy)
    monkeypatch.setattr("experiments.study.workers.TrialJob.__init__.__defaults__", (toy,))
    monkeypatch.setattr("experiments.belt.sweep.run_sweep.__defaults__", ("none", toy))


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


def test_help_needs_no_heavy_import(toy_environment):
    import subprocess

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
        (
            "trial --tracker igfp",
            "tracker must be one of igpf, pf, oracle, csrt; got 'igfp'; did you mean 'igpf'?",
        ),
        ("trial --camera ceiling", "camera must be one of far-side; got 'ceiling'"),
        ("trial --condition foggy", "condition must be normal, or NAME-LEVEL with a NAME of dark,"),
        ("trial --condition dark-9", "condition: dark has levels 0 to 4, got 'dark-9'"),
        ("trial --object ball", "object must be one of box; got 'ball'"),
        ("trial --motion zigzag", "motion must be one of constant; got 'zigzag'"),
        ("trial --predictor none", "predictor must be one of kalman; got 'none'"),
        (
            "sweep lop",
            "preset must be one of demo, smoke, loop, predictors, paper, real-cell, speed, stress,",
        ),
        ("sweep demo --seeds 0", "seeds must be 1 or greater, got 0"),
        ("sweep demo --trackers igfp", "tracker must be one of igpf, pf, oracle, csrt; got 'igfp'"),
        ("trial --tracker absent:It", "tracker 'absent:It': No module named 'absent'"),
        ("sweep demo --shard 4/3", "shard must be I/N with I from 1 to N, got '4/3'"),
        ("sweep demo --shard half", "shard must be I/N with I from 1 to N, as 2/4, got 'half'"),
        ("sweep demo --shard 10/10", "shard 10/10 of preset demo is empty: there are only 9"),
        ("sweep demo --dask nonsense", "no Dask scheduler answers at nonsense"),
        ("sweep demo --dask a:1 --workers 2", "workers are those of the Dask scheduler"),
        (
            "sweep demo --video some",
            "invalid choice 'some' for argument '--video'. Expected one of",
        ),
        ("merge nowhere --out all", "nowhere has no manifest.json of a sweep"),
        ("sweep demo --workers 0", "workers must be 1 or greater, got 0"),
        ("sweep", "Missing from beltgrasp sweep: PRESET Name of the preset"),
        ("swep demo", "Unrecognized options: swep, demo; Available subcommands: trial, sweep"),
        (
            "",
            "Expected one of {trial, sweep, merge, report, compare, list, view, otb, apple, "
            "bearing-only}.",
        ),
        ("report nowhere", "nowhere/trials.csv is missing or empty"),
        ("compare nowhere:igpf there", "nowhere/trials.csv is missing or empty"),
    ],
)
def test_what_the_user_got_wrong_is_one_line(
    capsys, registries, tmp_path, monkeypatch, arguments, expected
):
    monkeypatch.chdir(tmp_path)
    assert complain(capsys, *arguments.split()).startswith(expected)


def test_view_without_a_display_is_one_line(capsys, monkeypatch):
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert complain(capsys, "view").startswith("view needs a display")


def test_list_has_a_line_for_each_name(capsys, registries):
    assert cli.run(["list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "  igpf      the filter" in lines
    assert "control arms:" in lines


def test_a_trial_prints_a_summary_or_its_row(capsys, toy_trial):
    assert cli.run(["trial", "--speed-mps", "0.1", "--seed", "3"]) == 0
    assert "igpf at 0.1 m/s, seed 3" in capsys.readouterr().out
    rows = []
    for _ in range(2):
        assert cli.run(["trial", "--speed-mps", "0.1", "--seed", "3", "--json"]) == 0
        rows.append(json.loads(capsys.readouterr().out))
    assert rows[0] == rows[1]
    assert (rows[0]["preset"], rows[0]["seed"]) == ("trial", 3)


def test_a_trial_that_crashes_is_a_row_and_exit_code_1(capsys, toy_trial, monkeypatch):
    monkeypatch.setenv("TOY_CRASH_SEEDS", "3")
    assert cli.run(["trial", "--seed", "3", "--json"]) == 1
    captured = capsys.readouterr()
    assert json.loads(captured.out)["outcome"] == "error"
    assert captured.err.startswith("Traceback")


def test_sweep_and_report_end_to_end(capsys, toy_trial, tmp_path, monkeypatch):
    preset = Preset("mini", "", expand(tracker=["igpf", "pf"]), (0, 1))
    monkeypatch.setitem(presets.PRESETS, "mini", preset)
    monkeypatch.chdir(tmp_path)
    assert cli.run(["sweep", "mini", "--workers", "1"]) == 0
    assert "of 4 grasps succeeded: out/mini/trials.csv" in capsys.readouterr().out
    assert cli.run(["report", "out/mini"]) == 0
    assert "written: out/mini/figures/outcomes.png" in capsys.readouterr().out
    monkeypatch.setenv("TOY_CRASH_SEEDS", "1")
    assert cli.run(["sweep", "mini", "--out", "crashed", "--workers", "1"]) == 1
    assert "2 trials crashed; tracebacks: crashed/errors" in capsys.readouterr().err
    assert complain(capsys, "sweep", "demo", "--out", "out/mini").startswith(
        "out/mini holds results of preset 'mini', not of 'demo'"
    )


def test_shards_are_merged_to_the_whole(capsys, toy_trial, tmp_path, monkeypatch):
    monkeypatch.setitem(presets.PRESETS, "mini", Preset("mini", "", toy_sweep.CELLS, (0, 1)))
    monkeypatch.chdir(tmp_path)
    flags = ["--workers", "1", "--seeds", "2", "--trackers", "pf"]
    assert cli.run(["sweep", "mini", *flags, "--out", "whole"]) == 0
    assert cli.run(["sweep", "mini", *flags, "--shard", "1/2"]) == 0
    assert "mini: shard 1/2 of 2 cells x 2 seeds, 2 of 4 trials; " in capsys.readouterr().err
    assert cli.run(["merge", "out/mini-shard-1-of-2", "--out", "all"]) == 0
    captured = capsys.readouterr()
    assert captured.out == "2 rows: all/trials.csv\n"
    assert "warning: shard 2/2 lacks 2 of 2 trials: " in captured.err
    assert cli.run(["sweep", "mini", *flags, "--shard", "2/2", "--video", "all"]) == 0
    assert "2 videos: out/mini-shard-2-of-2/videos" in capsys.readouterr().out
    assert cli.run(["merge", "out/mini-shard-1-of-2", "out/mini-shard-2-of-2", "--out", "all"]) == 0
    assert capsys.readouterr().out.startswith("4 rows: all/trials.csv")
    assert toy_sweep.left_by(Path("all")) == toy_sweep.left_by(Path("whole"))


def test_ctrl_c_says_how_to_go_on(capsys, toy_trial, tmp_path, monkeypatch):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("experiments.belt.sweep._running_counts", interrupt)
    flags = ["--workers", "1", "--shard", "1/3", "--video", "all"]
    assert cli.run(["sweep", "demo", "--out", str(tmp_path / "s"), *flags]) == 130
    lines = capsys.readouterr().err.splitlines()
    assert lines[-2].endswith("the same command resumes:")
    command = f"  beltgrasp sweep demo --out {tmp_path / 's'} --shard 1/3 --video all"
    assert lines[-1] == command
