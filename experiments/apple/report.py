"""Rebuilds tables and figures of a folder of `beltgrasp apple` from its rows."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from experiments.apple.estimates import read_estimates
from experiments.apple.folder import study_of
from experiments.apple.tables import all_tables
from experiments.report import Report

_SHOWN = ("agreement", "table1", "table2", "errors", "folding")


def write_report(folder: Path) -> Report:
    """Writes `tables/` and `figures/` into the results folder of a command of `beltgrasp apple`."""
    study = study_of(folder)
    if study not in _REPORTS:
        raise ValueError(f"{folder} holds results of {study!r}, none of {', '.join(_REPORTS)}")
    return _REPORTS[study](folder)


def _tables_report(folder: Path) -> Report:
    from experiments.apple.figures import write_figures

    estimates = read_estimates(folder)
    tables = all_tables(estimates)
    paths = [
        path for name, table in tables.items() for path in table.write(folder / "tables", name)
    ]
    paths += write_figures(folder / "figures", estimates)
    return Report("\n".join(tables[name].to_text() for name in _SHOWN), tuple(paths))


_REPORTS: dict[str, Callable[[Path], Report]] = {"tables": _tables_report}
"""Command of `beltgrasp apple` -> what makes its report."""
