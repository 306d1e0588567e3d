"""A report from a folder's files alone: every table and figure, again the same, or why not."""

import dataclasses
import gzip

import pytest
from experiments.study.members import append_member

from experiments.belt.config import TrialConfig, TrialTimings
from experiments.belt.curves import CURVE_HEADER
from experiments.belt.presets import Preset, expand
from experiments.belt.report import write_report
from experiments.study import records

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
def write_folder():
    """Writes what a sweep leaves."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(__file__.rpartition("/belt/")[0])
        import toy_trial

    def write(folder):
        cells = expand(tracker=["igpf", "pf"], speed_mps=[0.1, 0.2, 0.3])
        cells += expand(camera=["overhead"], speed_mps=[0.1])
        append_member(folder / "curves.csv.gz", CURVE_HEADER)
        for config in Preset("p", "", cells, (0, 1)).trials:
            row, timings, curve = toy_trial.run_trial(config, preset="p")
            timings = dataclasses.replace(timings, wall_s=1.0)
            append_member(folder / "curves.csv.gz", curve)
            records.append_row(folder / "timings.csv", timings)
            records.append_row(folder / "trials.csv", row)
        return folder

    return write


@pytest.fixture(scope="module")
def reported(write_folder, tmp_path_factory):
    """A folder, and the report on it."""
    folder = write_folder(tmp_path_factory.mktemp("reported"))
    return folder, write_report(folder)


def test_a_report_writes_every_table_and_figure_in_every_format(reported):
    folder, report = reported
    names = {str(path.relative_to(folder)) for path in report.paths}
    assert names == {f"tables/{name}.{end}" for name in TABLES for end in ("csv", "md", "tex")} | {
        f"figures/{name}.{end}" for name in (*FIGURES, *CURVES) for end in ("png", "pdf")
    }
    assert all(path.stat().st_size > 0 for path in report.paths)
    assert "overhead" in report.text and "missing" not in report.text


def test_equal_files_give_equal_reports(reported, write_folder, tmp_path):
    _, report = reported
    again = write_report(write_folder(tmp_path))
    for first, second in zip(report.paths, again.paths, strict=True):
        assert first.read_bytes() == second.read_bytes(), first.name


def test_a_missing_file_costs_what_is_made_of_it_and_is_told(write_folder, tmp_path):
    write_folder(tmp_path)
    (tmp_path / "timings.csv").unlink()
    (tmp_path / "curves.csv.gz").unlink()
    report = write_report(tmp_path)
    assert f"no table of costs: {tmp_path / 'timings.csv'} is missing" in report.text
    assert f"no error curves: {tmp_path / 'curves.csv.gz'} is missing" in report.text
    names = {path.stem for path in report.paths}
    assert names == {*TABLES, *FIGURES} - {"costs"}


def test_a_running_sweep_can_be_reported(tmp_path, make_row):
    """The newest row may be torn, and its curve and timings may already be there."""
    row, next_row = (make_row(TrialConfig(seed=seed)) for seed in (0, 1))
    records.append_row(tmp_path / "trials.csv", row)
    for later in (row, next_row):
        timings = TrialTimings(later.trial_id, 1.0, 1.0, None, None, 1.0, 1.0)
        records.append_row(tmp_path / "timings.csv", timings)
    append_member(tmp_path / "curves.csv.gz", CURVE_HEADER)
    with (tmp_path / "curves.csv.gz").open("ab") as file:
        file.write(gzip.compress(b"torn")[:9])
    with (tmp_path / "trials.csv").open("a") as file:
        file.write("0123,p,ig")
    assert "igpf" in write_report(tmp_path).text


def test_a_folder_without_trials_is_named(tmp_path, make_row):
    with pytest.raises(ValueError, match=r"trials\.csv is missing or empty"):
        write_report(tmp_path)
    records.append_row(tmp_path / "trials.csv", make_row(TrialConfig()))
    lines = (tmp_path / "trials.csv").read_text().splitlines(keepends=True)
    (tmp_path / "trials.csv").write_text(lines[0])
    with pytest.raises(ValueError, match="holds no finished trial yet"):
        write_report(tmp_path)


def test_the_columns_that_an_earlier_sweep_lacks_are_named(tmp_path, make_row):
    records.append_row(tmp_path / "trials.csv", make_row(TrialConfig()))
    text = (tmp_path / "trials.csv").read_text()
    (tmp_path / "trials.csv").write_text(text.replace("particle_count,", "", 1))
    with pytest.raises(ValueError, match="missing: particle_count; unknown: none"):
        write_report(tmp_path)
