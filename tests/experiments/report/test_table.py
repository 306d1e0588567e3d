"""One table in four formats."""

import csv
import math

import pytest

from experiments.report.table import Column, Table, show_number


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
