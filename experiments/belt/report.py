"""Rebuilds every table and figure of a sweep from its rows."""

from collections.abc import Sequence

from experiments.belt.analysis.accuracy_table import accuracy_table
from experiments.belt.analysis.cell_tables import (
    blame_table,
    cost_table,
    outcome_table,
    success_table,
    tracking_table,
)
from experiments.belt.analysis.half_speed import half_speed_table
from experiments.belt.analysis.paired_tables import condition_table, paired_tables
from experiments.belt.config import TrialResult, TrialTimings
from experiments.belt.curves import CURVES, read_curves
from experiments.report.report import Report
from experiments.report.table import Table
from experiments.study.study import Results

_IN_TERMINAL = ("success", "half_speed", "verdicts", "conditions", "blame")
"""Tables that say in short what was found; the others are in the folder."""


def write_report(results: Results[TrialResult]) -> Report:
    """Writes `tables/` and `figures/` into the results folder of a sweep, finished or not."""
    from experiments.belt.analysis.figures import write_figures

    folder, rows = results.path, results.rows
    figures = write_figures(folder / "figures", rows, read_curves(results.curves[CURVES]))
    return Report.of(folder, _tables(rows, results.timings), figures, _IN_TERMINAL)


def _tables(results: Sequence[TrialResult], timings: Sequence[TrialTimings]) -> dict[str, Table]:
    return {
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
