import dataclasses
import json
import math
from pathlib import Path
from typing import Literal

import pytest

from experiments.study import rows


@dataclasses.dataclass(frozen=True)
class Row:
    name: str
    count: int
    share: float
    is_good: bool
    kind: Literal["a", "b"]
    outcome: Literal["done", "error"]
    error_m: float | None = None
    iteration: int | None = None
    detail: str = ""


PATH = Path("out") / "rows.csv"
ROW = Row("x", 3, 1 / 3, True, "b", "done", 2 / 3)


def lines_of(*written):
    return [rows.header_line(Row), *map(rows.row_line, written)]


def test_header_is_the_fields_of_the_row():
    assert rows.header_line(Row) == ",".join(rows.columns(Row)) + "\n"
    assert rows.columns(Row)[:3] == ["name", "count", "share"]


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
    assert rows.format_cell(value) == text


def test_a_list_is_not_a_cell():
    with pytest.raises(TypeError, match="a cell holds one scalar, got list"):
        rows.format_cell([1, 2])


def test_rows_come_back_typed_and_rounded():
    first, second = rows.parse_rows(PATH, lines_of(ROW, ROW), Row)
    assert first == second
    assert first == dataclasses.replace(ROW, share=0.333333333, error_m=0.666666667)
    assert rows.row_line(first) == rows.row_line(ROW)
    assert first.iteration is None


def test_text_with_commas_and_quotes_comes_back():
    row = dataclasses.replace(ROW, detail='a "quoted", comma')
    assert rows.parse_rows(PATH, lines_of(row), Row)[0].detail == row.detail


def test_columns_of_another_version_are_refused():
    with pytest.raises(ValueError, match=r"rows\.csv: .*\(missing: count, .*; unknown: colour\)"):
        rows.parse_rows(PATH, ["name,colour\n", "x,red\n"], Row)


@pytest.mark.parametrize(("cell", "wrong"), [(",true,", ",1,"), (",b,", ",c,"), (",3,", ",3.5,")])
def test_an_invalid_cell_names_file_and_line(cell, wrong):
    good, bad = rows.row_line(ROW), rows.row_line(ROW).replace(cell, wrong)
    assert good != bad
    with pytest.raises(ValueError, match=r"rows\.csv, line 3 is not a valid row"):
        rows.parse_rows(PATH, [rows.header_line(Row), good, bad], Row)


def test_a_line_of_too_few_cells_is_no_row():
    with pytest.raises(ValueError, match=r"rows\.csv, line 2 is not a valid row"):
        rows.parse_rows(PATH, [rows.header_line(Row), "x,3\n"], Row)


def test_json_equals_the_row():
    row = dataclasses.replace(ROW, share=math.nan)
    values = json.loads(json.dumps(rows.to_json(row), allow_nan=False))
    assert list(values) == rows.columns(Row)
    assert values["error_m"] == 0.666666667
    assert values["share"] is None
    assert values["is_good"] is True


def test_the_row_of_a_crash_has_what_is_known_and_nothing_measured():
    row = rows.error_row(Row, {"name": "x", "kind": "a", "commit": "c"}, "broke")
    assert row == Row("x", 0, 0.0, False, "a", "error", None, None, "broke")


def test_a_message_longer_than_a_cell_may_be_is_cut_off():
    row = rows.error_row(Row, {"name": "x", "kind": "a"}, "it broke " * 50_000)
    (read,) = rows.parse_rows(PATH, lines_of(row), Row)
    assert read.detail.startswith("it broke it broke")
