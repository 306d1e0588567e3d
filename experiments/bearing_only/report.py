"""Rebuilds every table and figure of a study of flights from its rows."""

# pyright: basic, reportArgumentType=false
# pandas is annotated in part: what a selection or a group gives is not known.

from __future__ import annotations

import io
from dataclasses import asdict

import pandas as pd

from experiments.bearing_only.config import FlightResult
from experiments.bearing_only.tables import behaviour_table, cost_table, error_table, ratio_table
from experiments.bearing_only.traces import CURVE_HEADER, CURVES
from experiments.report.report import Report
from experiments.study.study import Results


def write_report(results: Results[FlightResult]) -> Report:
    """Writes `tables/` and `figures/` into a results folder of `beltgrasp bearing-only`."""
    from experiments.bearing_only.figures import write_figures

    runs = pd.DataFrame([asdict(row) for row in results.rows])
    timings = pd.DataFrame([asdict(row) for row in results.timings])
    curves = pd.read_csv(io.StringIO(CURVE_HEADER + "".join(results.curves[CURVES].values())))
    tables = {
        "errors": error_table(runs),
        "behaviour": behaviour_table(runs),
        "ratios": ratio_table(runs),
        "costs": cost_table(runs, timings),
    }
    figures = write_figures(results.path / "figures", results.path, runs, curves)
    return Report.of(results.path, tables, figures)
