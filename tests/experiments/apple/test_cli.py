"""`beltgrasp apple` as its users run it."""

import subprocess
import sys

import pytest

from experiments import cli
from experiments.study.manifest import Manifest


def beltgrasp(*words):
    command = [sys.executable, "-m", "experiments.cli", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "apple"
    run = beltgrasp("apple", "tables", "--out", path, "--seeds", 5, "--workers", 1)
    assert run.returncode == 0, run.stderr
    assert f"14 filter runs: {path / 'rows.csv'}" in run.stdout
    assert cli.run(["report", str(path)]) == 0
    return path


def test_it_leaves_rows_tables_figures_and_a_manifest(folder):
    assert (folder / "rows.csv").read_text().count("\n") == 1 + 7 * (6 + 5)
    for name in ("agreement", "table1", "table2", "errors", "conversion", "folding"):
        assert {p.suffix for p in folder.glob(f"tables/{name}.*")} == {".csv", ".md", ".tex"}
    assert {p.name for p in folder.glob("figures/*.png")} == {"table1.png", "table2.png"}
    manifest = Manifest.read(folder)
    assert manifest.selections[0]["seeds"] == [0, 1, 2, 3, 4]
    assert len(manifest.sessions) == 1


def test_the_report_rebuilds_the_same_files(folder, capsys):
    files = [*folder.glob("tables/*"), *folder.glob("figures/*.png"), folder / "rows.csv"]
    before = {path: path.read_bytes() for path in files}
    assert cli.run(["apple", "tables", "--out", str(folder), "--seeds", "5"]) == 0
    assert cli.run(["report", str(folder)]) == 0
    text = capsys.readouterr().out
    assert "written:" in text and "85.53, 79.61, 11.61" in text
    assert {path: path.read_bytes() for path in files} == before


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--particle-count", "9"], "other settings: filter.particle_count was 200, is 9; choose"),
        (["--seeds", "0"], "seeds must be 1 or greater, got 0"),
        (["--walk-sigma-cm", "-1"], "walk_sigma_cm must be a positive"),
        (["--particle-count", "0"], "particle_count must be 1 or"),
        (["--video", "all"], "apple/tables has no videos; --video must be none"),
    ],
)
def test_what_is_wrong_is_told_in_one_line(folder, capsys, words, message):
    assert cli.run(["apple", "tables", "--out", str(folder), "--workers", "1", *words]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
