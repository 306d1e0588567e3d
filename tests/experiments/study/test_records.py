import dataclasses
import json
import math

import pytest

from experiments.belt.config import TrialConfig, TrialResult, TrialTimings
from experiments.study import records


@pytest.fixture
def row(make_row):
    return make_row(TrialConfig(seed=1), time_to_grasp_s=1 / 3, outcome="missed")


def test_header_is_the_fields_of_the_result():
    names = [field.name for field in dataclasses.fields(TrialResult)]
    assert records.header_line(TrialResult) == ",".join(names) + "\n"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, ""),
        (True, "true"),
        (False, "false"),
        (0.1, "0.1"),
        (1 / 3, "0.333333333"),
        (-0.0, "0"),
        (1e-12, "1e-12"),
        (7, "7"),
        ("two\nlines\u2028or three", "two lines or three"),
        (math.nan, "nan"),
        ("a file named \udcff", "a file named \\udcff"),
    ],
)
def test_cells_have_one_format(value, text):
    assert records.format_cell(value) == text


def test_a_list_is_not_a_cell():
    with pytest.raises(TypeError, match="a cell holds one scalar, got list"):
        records.format_cell([1, 2])


def test_rows_come_back_typed(tmp_path, row):
    path = tmp_path / "trials.csv"
    for _ in range(2):
        records.append_row(path, row)
    first, second = records.read_rows(path, TrialResult)
    assert first == second
    assert first.time_to_grasp_s == pytest.approx(1 / 3, rel=1e-8)
    rounded = dataclasses.replace(
        row,
        **{
            name: float(records.format_cell(value))
            for name, value in dataclasses.asdict(row).items()
            if isinstance(value, float)
        },
    )
    assert first == rounded
    assert records.row_line(first) == records.row_line(row)


def test_a_torn_last_line_is_ignored_by_readers_and_cut_off_by_the_writer(tmp_path, row):
    path = tmp_path / "trials.csv"
    records.append_row(path, row)
    whole = path.read_bytes()
    for length in range(1, len(records.row_line(row)), 37):
        path.write_bytes(whole + records.row_line(row).encode()[:length])
        assert len(records.read_rows(path, TrialResult)) == 1
        records.append_row(path, row)
        assert path.read_bytes() == whole + records.row_line(row).encode()


def test_a_torn_header_is_written_again(tmp_path, row):
    path = tmp_path / "trials.csv"
    path.write_text("trial_id,pre")
    records.append_row(path, row)
    assert len(records.read_rows(path, TrialResult)) == 1


def test_columns_of_another_version_are_refused(tmp_path):
    path = tmp_path / "trials.csv"
    path.write_text("trial_id,colour\nabc,red\n")
    with pytest.raises(ValueError, match=r"missing: preset, .*; unknown: colour"):
        records.read_rows(path, TrialResult)


@pytest.mark.parametrize("cell", ["maybe", "1"])
def test_an_invalid_cell_names_file_and_line(tmp_path, row, cell):
    path = tmp_path / "trials.csv"
    records.append_row(path, row)
    path.write_text(path.read_text().replace(",true,", f",{cell},").replace(",false,", f",{cell},"))
    with pytest.raises(ValueError, match=r"trials\.csv, line 2 is not a valid row"):
        records.read_rows(path, TrialResult)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ValueError, match=r"trials\.csv is missing or empty"):
        records.read_rows(tmp_path / "trials.csv", TrialResult)


def test_json_equals_the_row(make_row):
    row = make_row(TrialConfig(), time_to_grasp_s=1 / 3, belt_used_m=math.nan)
    values = json.loads(json.dumps(records.to_json(row), allow_nan=False))
    assert list(values) == [field.name for field in dataclasses.fields(TrialResult)]
    assert values["time_to_grasp_s"] == 0.333333333
    assert values["belt_used_m"] is None
    assert values["is_early_contact"] is False


def test_the_row_of_a_crash_has_its_configuration_and_nothing_measured():
    config = TrialConfig(tracker="pf", seed=4)
    provenance = {"preset": "p", "commit": "c", "mujoco_version": "3"}
    row = records.error_result(config, "broke", provenance)
    assert (row.trial_id, row.tracker, row.seed) == (config.trial_id, "pf", 4)
    assert (row.outcome, row.success, row.detail) == ("error", False, "broke")
    assert row.track_rmse_m is None
    timings = records.error_timings(config, 1.5)
    assert isinstance(timings, TrialTimings)
    assert timings.wall_s == 1.5


def test_a_message_longer_than_a_cell_may_be_is_cut_off(tmp_path):
    provenance = {"preset": "p", "commit": "c", "mujoco_version": "3"}
    row = records.error_result(TrialConfig(), "it broke " * 50_000, provenance)
    records.append_row(tmp_path / "trials.csv", row)
    (read,) = records.read_rows(tmp_path / "trials.csv", TrialResult)
    assert read.detail.startswith("it broke it broke")
