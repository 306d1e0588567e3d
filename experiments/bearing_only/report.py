"""Rebuilds every table and figure of a folder of flights from its files."""

# pyright: basic, reportArgumentType=false, reportAttributeAccessIssue=false, reportCallIssue=false, reportGeneralTypeIssues=false
# pandas is annotated in part: what a selection or a group gives is not known.

from __future__ import annotations

from pathlib import Path

import pandas as pd

from experiments.bearing_only.folder import CURVES, KIND, RUNS, TIMINGS
from experiments.bearing_only.tables import behaviour_table, cost_table, error_table, ratio_table
from experiments.bearing_only.traces import read_curves
from experiments.belt.report import Report
from experiments.report.table import write_tables
from experiments.study.study_folder import study_of


def write_report(folder: Path) -> Report:
    """Writes `tables/` and `figures/` into a results folder of `beltgrasp bearing-only`."""
    study_of(folder, KIND, "bearing-only")
    runs = pd.read_csv(folder / RUNS, keep_default_na=False, na_values=[""])
    if runs.empty:
        raise ValueError(f"{folder / RUNS} holds no finished flight yet")
    timings = pd.read_csv(folder / TIMINGS)
    from experiments.bearing_only.figures import write_figures

    made = {
        "errors": error_table(runs),
        "behaviour": behaviour_table(runs),
        "ratios": ratio_table(runs),
        "costs": cost_table(runs, timings),
    }
    tables = {name: table for name, table in made.items() if table is not None}
    paths = write_tables(folder / "tables", tables)
    paths += write_figures(folder / "figures", folder, runs, read_curves(folder / CURVES))
    return Report("\n".join(table.to_text() for table in tables.values()), tuple(paths))
