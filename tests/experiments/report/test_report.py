"""What a report leaves."""

from pathlib import Path

import pytest

from experiments.report.report import Report
from experiments.report.table import Table, words


@pytest.fixture
def tables():
    empty = Table.of([], *words("n"))
    return {"first": Table.of([{"n": 1}], *words("n")), "empty": empty} | {
        "last": Table.of([{"n": 2}], *words("n"))
    }


def test_a_report_holds_its_tables_and_its_files(tables, tmp_path):
    report = Report.of(tmp_path, tables, [Path("figure.png")])
    names = ("first.csv", "first.md", "first.tex", "last.csv", "last.md", "last.tex")
    assert report.paths == (*(tmp_path / "tables" / name for name in names), Path("figure.png"))
    assert report.text == "n\n-\n1\n\nn\n-\n2\n"


def test_the_text_holds_what_is_chosen_and_the_notes(tables, tmp_path, capsys):
    report = Report.of(tmp_path, tables, [], ("last", "empty", "missing"), ["no costs"])
    assert report.text == "n\n-\n2\n\nno costs"
    report.show()
    assert capsys.readouterr().out.splitlines()[-1] == f"written: {tmp_path / 'tables/last.tex'}"
