import shutil

import pytest

from experiments import figures, records
from experiments.config import TrialConfig
from experiments.presets import Preset, expand
from experiments.report import write_report


@pytest.fixture
def folder(tmp_path, make_row):
    cells = expand(tracker=["igpf", "pf", "mine"], camera=["far-side", "overhead"])
    for config in Preset("p", "", cells, tuple(range(3))).trials:
        records.append_row(tmp_path / "trials.csv", make_row(config))
    return tmp_path


def test_a_report_writes_every_table_and_figure(folder):
    report = write_report(folder)
    names = {str(path.relative_to(folder)) for path in report.paths}
    assert names == {
        "tables/success.csv",
        "tables/success.md",
        "tables/outcomes.csv",
        "tables/outcomes.md",
        "tables/paired.csv",
        "tables/paired.md",
        "figures/success_vs_speed.png",
        "figures/success_vs_speed.pdf",
        "figures/outcomes.png",
    }
    assert all(path.stat().st_size > 0 for path in report.paths)
    assert "overhead" in report.text


def test_equal_rows_give_equal_files(folder, tmp_path_factory):
    other = tmp_path_factory.mktemp("other")
    shutil.copy(folder / "trials.csv", other)
    for first, second in zip(write_report(folder).paths, write_report(other).paths, strict=True):
        assert first.read_bytes() == second.read_bytes(), first.name


def test_a_running_sweep_can_be_reported(folder):
    with (folder / "trials.csv").open("a") as file:
        file.write("0123,p,ig")
    assert "igpf" in write_report(folder).text


def test_a_folder_without_trials_is_named(tmp_path, make_row):
    with pytest.raises(ValueError, match=r"trials\.csv is missing or empty"):
        write_report(tmp_path)
    records.append_row(tmp_path / "trials.csv", make_row(TrialConfig()))
    lines = (tmp_path / "trials.csv").read_text().splitlines(keepends=True)
    (tmp_path / "trials.csv").write_text(lines[0])
    with pytest.raises(ValueError, match="holds no finished trial yet"):
        write_report(tmp_path)


def test_colours_belong_to_trackers():
    assert figures.tracker_style("igpf") == figures.TRACKER_STYLES["igpf"]
    assert figures.tracker_style("mine") == figures.tracker_style("mine")
    colours = [style[0] for style in figures.TRACKER_STYLES.values()]
    assert len(set(colours)) == len(colours)
