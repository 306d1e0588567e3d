"""Rebuilds every table and figure of a results folder from its trials.csv."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from experiments import records
from experiments.config import TrialResult
from experiments.tables import blame_table, outcome_table, paired_table, success_table


@dataclass(frozen=True)
class Report:
    """What was written, and the tables as text for a terminal."""

    text: str
    paths: tuple[Path, ...]


def write_report(folder: Path) -> Report:
    """Writes `tables/` and `figures/` beside the trials.csv of `folder`."""
    results = records.read_rows(folder / "trials.csv", TrialResult)
    if not results:
        raise ValueError(f"{folder / 'trials.csv'} holds no finished trial yet")
    from experiments.figures import write_figures

    text, paths = _write_tables(folder / "tables", results)
    return Report(text, (*paths, *write_figures(folder / "figures", results)))


def _write_tables(folder: Path, results: Sequence[TrialResult]) -> tuple[str, list[Path]]:
    success = success_table(results)
    paths = success.write(folder, "success")
    paths += outcome_table(results).write(folder, "outcomes")
    text = success.to_text()
    for name, table in (("paired", paired_table(results)), ("blame", blame_table(results))):
        if table is not None:
            paths += table.write(folder, name)
            text += "\n" + table.to_text()
    return text, paths
