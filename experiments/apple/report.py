"""Rebuilds tables and figures of a folder of `beltgrasp apple` from its rows."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from experiments.apple.estimates import read_estimates
from experiments.apple.tables import all_tables
from experiments.belt.report import Report
from experiments.report.table import Table, write_tables
from experiments.study.study_folder import study_of

_SHOWN = ("agreement", "table1", "table2", "errors", "folding")


def write_report(folder: Path) -> Report:
    """Writes `tables/` and `figures/` into the results folder of a command of `beltgrasp apple`."""
    study = study_of(folder, "apple", "apple")
    if study not in _REPORTS:
        raise ValueError(f"{folder} holds results of {study!r}, none of {', '.join(_REPORTS)}")
    return _REPORTS[study](folder)


def _tables_report(folder: Path) -> Report:
    from experiments.apple.figures import write_figures

    estimates = read_estimates(folder)
    tables = all_tables(estimates)
    paths = write_tables(folder / "tables", tables)
    paths += write_figures(folder / "figures", estimates)
    return Report("\n".join(tables[name].to_text() for name in _SHOWN), tuple(paths))


def _replay_report(folder: Path) -> Report:
    from experiments.apple.rendered_figures import write_replay_figures
    from experiments.apple.replay import replay_file
    from experiments.apple.replay_tables import replay_tables

    rows = replay_file(folder).read()
    return _written(folder, replay_tables(rows), write_replay_figures(folder / "figures", rows))


def _approach_report(folder: Path) -> Report:
    from experiments.apple.approach import approach_file
    from experiments.apple.approach_tables import approach_tables
    from experiments.apple.rendered_figures import write_approach_figures

    rows = approach_file(folder).read()
    figures = write_approach_figures(folder / "figures", rows)
    return _written(folder, approach_tables(rows), figures)


def _written(folder: Path, tables: dict[str, Table], figures: list[Path]) -> Report:
    paths = write_tables(folder / "tables", tables)
    return Report("\n".join(table.to_text() for table in tables.values()), (*paths, *figures))


_REPORTS: dict[str, Callable[[Path], Report]] = {
    "tables": _tables_report,
    "replay": _replay_report,
    "approach": _approach_report,
}
"""Command of `beltgrasp apple` -> what makes its report."""
