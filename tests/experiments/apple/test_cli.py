"""`beltgrasp apple` as its users run it."""

import json
import subprocess
import sys

import pytest

from experiments import cli


def beltgrasp(*words):
    command = [sys.executable, "-m", "experiments.cli", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "apple"
    run = beltgrasp("apple", "tables", "--out", path, "--seeds", 5)
    assert run.returncode == 0, run.stderr
    assert "85.53, 79.61, 11.61" in run.stdout
    return path


def test_it_leaves_rows_tables_figures_and_a_manifest(folder):
    assert (folder / "estimates.csv").read_text().count("\n") == 1 + 7 * (6 + 5)
    for name in ("agreement", "table1", "table2", "errors", "conversion", "folding"):
        assert {p.suffix for p in folder.glob(f"tables/{name}.*")} == {".csv", ".md", ".tex"}
    assert {p.name for p in folder.glob("figures/*.png")} == {"table1.png", "table2.png"}
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest["settings"]["seeds"] == 5
    assert len(manifest["sessions"]) == 1


def test_the_report_rebuilds_the_same_files(folder, capsys):
    files = [*folder.glob("tables/*"), *folder.glob("figures/*.png"), folder / "estimates.csv"]
    before = {path: path.read_bytes() for path in files}
    assert cli.run(["apple", "tables", "--out", str(folder), "--seeds", "5"]) == 0
    assert cli.run(["apple", "report", str(folder)]) == 0
    assert "written:" in capsys.readouterr().out
    assert {path: path.read_bytes() for path in files} == before


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["tables", "--out", "OUT", "--seeds", "6"], "holds results with seeds 5, not 6"),
        (["tables", "--out", "NEW", "--seeds", "0"], "seeds must be 1 or greater, got 0"),
        (["tables", "--out", "NEW", "--walk-sigma-cm", "-1"], "walk_sigma_cm must be a positive"),
        (["tables", "--out", "NEW", "--particle-count", "0"], "particle_count must be 1 or"),
        (["report", "NEW"], "holds no results of `beltgrasp apple`"),
        (["tables"], "--out"),
    ],
)
def test_what_is_wrong_is_told_in_one_line(folder, tmp_path, capsys, words, message):
    places = {"OUT": str(folder), "NEW": str(tmp_path / "new")}
    assert cli.run(["apple", *(places.get(word, word) for word in words)]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


def test_a_folder_of_another_command_is_refused(tmp_path, capsys):
    (tmp_path / "manifest.json").write_text('{"preset": "loop"}')
    assert cli.run(["apple", "tables", "--out", str(tmp_path)]) == 2
    assert "holds results of another command" in capsys.readouterr().err
    (tmp_path / "manifest.json").write_text('{"apple": "dance"}')
    assert cli.run(["apple", "report", str(tmp_path)]) == 2
    assert "'dance', none of tables" in capsys.readouterr().err


def test_rows_without_a_manifest_are_not_overwritten(tmp_path, capsys):
    (tmp_path / "estimates.csv").write_text("mine\n")
    assert cli.run(["apple", "tables", "--out", str(tmp_path)]) == 2
    assert "without their manifest.json" in capsys.readouterr().err
    assert (tmp_path / "estimates.csv").read_text() == "mine\n"
