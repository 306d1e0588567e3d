"""A report from a folder's files alone: every table and figure, again the same, or why not."""

import json
import shutil
from dataclasses import asdict, replace

import pytest
import toy_study

from experiments.belt.presets import expand
from experiments.belt.report import write_report
from experiments.belt.study import get_study, selection_of
from experiments.study.folder import read_entries, read_results
from experiments.study.run import run

STUDY = replace(get_study("belt/p"), work="toy_trial:run_trials")
TABLES = (
    "success",
    "tracking",
    "outcomes",
    "costs",
    "half_speed",
    "accuracy",
    "paired",
    "verdicts",
)
FIGURES = ("success_vs_speed", "success_matrix", "outcomes")
CURVES = ("error_curves", "error_bars")


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """A folder that a sweep has left; not to be written to."""
    cells = expand(tracker=["igpf", "pf"], speed_mps=[0.1, 0.2, 0.3])
    cells += expand(camera=["overhead"], speed_mps=[0.1])
    folder = tmp_path_factory.mktemp("swept") / "p"
    run(STUDY, selection_of(cells, (0, 1)), folder, toy_study.ThisProcess())
    return folder


@pytest.fixture(scope="module")
def reported(swept, tmp_path_factory):
    """A folder, and the report on it."""
    folder = shutil.copytree(swept, tmp_path_factory.mktemp("reported") / "p")
    return folder, report_on(folder)


def report_on(folder):
    return write_report(read_results(folder, STUDY))


def test_a_report_writes_every_table_and_figure_in_every_format(reported):
    folder, report = reported
    names = {str(path.relative_to(folder)) for path in report.paths}
    assert names == {f"tables/{name}.{end}" for name in TABLES for end in ("csv", "md", "tex")} | {
        f"figures/{name}.{end}" for name in (*FIGURES, *CURVES) for end in ("png", "pdf")
    }
    assert all(path.stat().st_size > 0 for path in report.paths)
    assert "overhead" in report.text and "missing" not in report.text


def test_equal_files_give_equal_reports(reported, swept, tmp_path):
    _, report = reported
    again = report_on(shutil.copytree(swept, tmp_path / "p"))
    for first, second in zip(report.paths, again.paths, strict=True):
        assert first.read_bytes() == second.read_bytes(), first.name


def test_a_running_sweep_can_be_reported(swept, tmp_path):
    """One trial has ended, and the next is being written."""
    folder = shutil.copytree(swept, tmp_path / "p")
    for name in ("rows.csv", "timings.csv", "curves.csv.gz"):
        (folder / name).unlink()
    entry = next(iter(read_entries(swept, STUDY).values()))
    line = json.dumps(asdict(entry)) + "\n"
    (folder / "journal.jsonl").write_text(line + line[:40])
    report = report_on(folder)
    assert "igpf" in report.text
    assert {path.stem for path in report.paths} >= {"success", "error_curves"}
