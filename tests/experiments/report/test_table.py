"""One table in four formats."""

import csv
import math

import pytest

from experiments.report.table import (
    Column,
    Table,
    interval,
    number,
    numbers,
    p_value,
    rate,
    show_number,
    show_p,
    word,
    words,
    write_tables,
)


@pytest.fixture
def table():
    rows = (
        {"tracker": "my_mod:A&B", "rate": 0.5, "difference": -0.25, "p": None},
        {"tracker": "igpf", "rate": 1.0, "difference": 0.125, "p": 0.0001},
    )
    columns = (
        Column("tracker", lambda row: row["tracker"]),
        Column("rate % [95 %]", lambda row: f"{100 * row['rate']:.1f}"),
        Column("difference", lambda row: f"{row['difference']:+.2f}"),
        Column("p", lambda row: "< 0.001" if row["p"] else "-"),
    )
    return Table(rows, columns)


def test_csv_holds_the_raw_values(table):
    first, second = csv.DictReader(table.to_csv().splitlines())
    assert float(first["difference"]) == -0.25 and first["p"] == ""
    assert float(second["p"]) == 0.0001


def test_a_csv_has_one_header_for_all_rows():
    table = Table.of([{"n": 1}, {"n": 2, "more": 3}], *words("n"))
    with pytest.raises(ValueError, match="every row of a table must have the columns n; got n, mo"):
        table.to_csv()


def test_markdown_and_text_hold_the_shown_cells(table):
    lines = table.to_markdown().splitlines()
    assert lines[0] == "| tracker | rate % [95 %] | difference | p |"
    assert lines[2] == "| my_mod:A&B | 50.0 | -0.25 | - |"
    text = table.to_text().splitlines()
    assert len({len(line) for line in text}) == 1, "right-aligned numbers end in one column"
    assert text[2].startswith("my_mod:A&B") and text[3].startswith("igpf ")


def test_latex_is_a_booktabs_tabular_with_its_own_characters_escaped(table):
    assert table.to_latex().splitlines() == [
        r"\begin{tabular}{lrrr}",
        r"\toprule",
        r"tracker & rate \% [95 \%] & difference & p \\",
        r"\midrule",
        r"my\_mod:A\&B & 50.0 & $-$0.25 & -- \\",
        r"igpf & 100.0 & +0.12 & $<$ 0.001 \\",
        r"\bottomrule",
        r"\end{tabular}",
    ]


@pytest.mark.parametrize(
    ("cell", "latex"),
    [
        ("dark-3+blur-1", "dark-3+blur-1"),
        ("+9.3 [-3.2, +15.2]", "+9.3 [$-$3.2, +15.2]"),
        ("a\\b~c^d#{e}$", r"a\textbackslash{}b\textasciitilde{}c\textasciicircum{}d\#\{e\}\$"),
    ],
)
def test_a_name_keeps_its_hyphens_and_a_number_gets_a_minus(cell, latex):
    table = Table(({"x": cell},), (Column("x", lambda row: row["x"]),))
    assert table.to_latex().splitlines()[4] == latex + r" \\"


def test_a_table_is_written_in_every_format(table, tmp_path):
    paths = table.write(tmp_path / "tables", "success")
    assert [path.name for path in paths] == ["success.csv", "success.md", "success.tex"]
    assert paths[2].read_text() == table.to_latex()


def test_numbers_have_one_format():
    shown = [show_number(value) for value in (None, math.nan, 1.005, 2)]
    assert shown == ["-", "-", "1.00", "2.00"]


def test_small_p_has_a_bound():
    assert [show_p(p) for p in (0.0004, 0.0316, 1.0)] == ["< 0.001", "0.032", "1.000"]


def shown(column, row):
    return column.label, column.show(row)


def test_columns_of_words_and_numbers():
    row = {"n": 3, "name": "igpf", "error": 0.01234, "share": 0.875, "p": 0.5, "none": None}
    assert [shown(column, row) for column in words("n", "name")] == [("n", "3"), ("name", "igpf")]
    assert shown(word("against", "name"), row) == ("against", "igpf")
    assert shown(word("against", "none"), row) == ("against", "-")
    assert shown(number("e", "error"), row) == ("e", "0.01")
    assert shown(number("e [mm]", "error", 1, 1e3), row) == ("e [mm]", "12.3")
    assert shown(number("e", "none"), row) == ("e", "-")
    assert shown(rate("s %", "share"), row) == ("s %", "87.5")
    assert shown(rate("s %", "none"), row) == ("s %", "-")
    assert shown(p_value("p", "p"), row) == ("p", "0.500")
    several = numbers([("error", "e", 3), ("share", "s", 1)])
    assert [shown(column, row) for column in several] == [("e", "0.012"), ("s", "0.9")]


def test_an_interval_shows_what_there_is():
    row = {"x": 0.25, "low": -0.1, "high": 0.6, "none": None}
    assert interval("x", "x", "low", "high").show(row) == "0.25 [-0.10, 0.60]"
    percent = interval("x", "x", "low", "high", digits=1, factor=100.0, sign="+")
    assert percent.show(row) == "+25.0 [-10.0, +60.0]"
    assert interval("[95 %]", "low", "high", digits=3).show(row) == "[-0.100, 0.600]"
    assert interval("x", "x", "none", "none").show(row) == "0.25"
    assert interval("x", "none", "none", "none").show(row) == "-"
    assert interval("[95 %]", "none", "none").show(row) == "-"


def test_a_table_without_rows_is_not_written(table, tmp_path):
    paths = write_tables(tmp_path, {"empty": Table.of([], *table.columns), "full": table})
    assert [path.name for path in paths] == ["full.csv", "full.md", "full.tex"]
