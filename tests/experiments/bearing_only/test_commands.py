"""End to end: the command as a subprocess, then resumed, reported and fed with what is wrong."""

import csv
import os
import subprocess
import sys

import pytest

from experiments import cli

CIRCLE = "bearing-only circle --seeds 2 --iterations 30 --landmarks 30".split()


def beltgrasp(*words):
    command = [sys.executable, "-m", "experiments.cli", *map(str, words)]
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    out = tmp_path_factory.mktemp("flown") / "out"
    done = beltgrasp(*CIRCLE, "--controllers", "gradient,known-pose", "--workers", 2, "--out", out)
    assert done.returncode == 0, done.stderr
    assert f"4 flights: {out / 'rows.csv'}" in done.stdout
    return out


def test_rows_are_in_order_and_do_not_depend_on_workers_or_interruptions(flown, tmp_path):
    with (flown / "rows.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [(row["controller"], row["seed"]) for row in rows] == [
        (name, seed) for name in ("gradient", "known-pose") for seed in "01"
    ]
    assert {row["outcome"] for row in rows} == {"tracked"}
    parts = [*CIRCLE, "--workers", "1", "--out", str(tmp_path)]
    assert cli.run([*parts, "--controllers", "known-pose"]) == 0
    assert cli.run([*parts, "--controllers", "gradient"]) == 0
    for name in ("rows.csv", "curves.csv.gz"):
        assert (tmp_path / name).read_bytes() == (flown / name).read_bytes()
    traces = sorted(path.name for path in (flown / "traces").iterdir())
    assert traces == ["gradient_prior0.2_v2.5.csv", "gradient_prior0.2_v2.5_map.csv"]


def test_the_report_has_tables_and_figures(flown, capsys):
    assert cli.run(["report", str(flown)]) == 0
    text = capsys.readouterr().out
    assert "dead reckoning" in text
    for name in ("tables/errors.md", "tables/ratios.csv", "figures/top_view_prior0.2.png",
                 "figures/control_prior0.2.pdf"):  # fmt: skip
        assert (flown / name).stat().st_size > 0


def test_what_the_user_got_wrong_is_one_line(flown, tmp_path, capsys):
    out = ["--out", str(tmp_path / "new")]
    for words, expected in (
        (["circle", *out, "--controllers", "gradeint"], "controller must be one of published,"),
        (["circle", *out, "--v-max-mps", "0"], "v_max_mps must be a positive number, got 0.0"),
        (["circle", *out, "--target-speed-mps", "nan"], "target_speed_mps must be a positive"),
        (["circle", *out, "--landmarks", "-1"], "landmark_count must be 0 or greater, got -1"),
        (["circle", *out, "--seeds", "0"], "seeds must be 1 or greater, got 0"),
        (["circle", *out, "--workers", "0"], "workers must be 1 or greater, got 0"),
        (
            ["line", "--out", str(flown)],
            f"{flown} holds results of bearing-only/circle, not of bearing-only/line; choose",
        ),
    ):
        assert cli.run(["bearing-only", *words]) == 2
        captured = capsys.readouterr()
        assert captured.err.startswith(f"beltgrasp: error: {expected}"), captured.err
        assert captured.err.count("\n") == 1


def test_a_film_is_made(tmp_path):
    words = "bearing-only circle --seeds 1 --iterations 6 --landmarks 10 --controllers follow"
    words = [*words.split(), "--workers", "1", "--video", "all", "--out", str(tmp_path)]
    assert cli.run(words) == 0
    (film,) = (tmp_path / "videos").iterdir()
    assert film.stat().st_size > 1000
    assert film.name.startswith("PASS_tracked_circle_follow_prior_0.2_2.5_m_s_seed_0_")
