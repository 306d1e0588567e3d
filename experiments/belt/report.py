"""Rebuilds every table and figure of a results folder from its CSV files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from experiments.belt.accuracy_table import accuracy_table
from experiments.belt.config import TrialResult, TrialTimings
from experiments.belt.curves import ErrorCurve, read_curves
from experiments.belt.half_speed import half_speed_table
from experiments.belt.paired_tables import condition_table, paired_tables
from experiments.belt.tables import (
    blame_table,
    cost_table,
    outcome_table,
    success_table,
    tracking_table,
)
from experiments.report.table import Table, write_tables
from experiments.study import records

_IN_TERMINAL = ("success", "half_speed", "verdicts", "conditions", "blame")
"""Tables that say in short what was found; the others are in the folder."""


@dataclass(frozen=True)
class Report:
    """What was written, and the tables as text for a terminal."""

    text: str
    paths: tuple[Path, ...]

    def show(self) -> None:
        """Prints the tables, and the files."""
        print(self.text)
        print("\n".join(f"written: {path}" for path in self.paths))


def write_report(folder: Path) -> Report:
    """Writes `tables/` and `figures/` beside the trials.csv of `folder`.

    What else a sweep leaves may be missing; the text then says what could not be made.
    """
    results = records.read_rows(folder / "trials.csv", TrialResult)
    if not results:
        raise ValueError(f"{folder / 'trials.csv'} holds no finished trial yet")
    notes: list[str] = []
    timings = _read_timings(folder / "timings.csv", notes)
    curves = _read_curves(folder / "curves.csv.gz", notes)
    from experiments.belt.figures import write_figures

    tables = _tables(results, timings)
    paths = write_tables(folder / "tables", tables)
    paths += write_figures(folder / "figures", results, curves)
    shown = [tables[name].to_text() for name in _IN_TERMINAL if name in tables]
    return Report("\n".join([*shown, *notes]), tuple(paths))


def _tables(results: Sequence[TrialResult], timings: Sequence[TrialTimings]) -> dict[str, Table]:
    tables: dict[str, Table | None] = {
        "success": success_table(results),
        "tracking": tracking_table(results),
        "outcomes": outcome_table(results),
        "costs": cost_table(results, timings),
        "half_speed": half_speed_table(results),
        **paired_tables(results),
        "accuracy": accuracy_table(results),
        "conditions": condition_table(results),
        "blame": blame_table(results),
    }
    return {name: table for name, table in tables.items() if table is not None}


def _read_timings(path: Path, notes: list[str]) -> list[TrialTimings]:
    if path.exists():
        return records.read_rows(path, TrialTimings)
    notes.append(f"no table of costs: {path} is missing")
    return []


def _read_curves(path: Path, notes: list[str]) -> Mapping[str, ErrorCurve]:
    if path.exists():
        return read_curves(path)
    notes.append(f"no error curves: {path} is missing")
    return {}
