"""Rebuilds every table and figure of a study of flights from its rows."""

from experiments.bearing_only.config import FlightResult
from experiments.bearing_only.tables import behaviour_table, cost_table, error_table, ratio_table
from experiments.bearing_only.traces import CURVE_HEADER, CURVES, parse_table
from experiments.report.report import Report
from experiments.study.study import Results


def write_report(results: Results[FlightResult]) -> Report:
    """Writes `tables/` and `figures/` into a results folder of `beltgrasp bearing-only`."""
    from experiments.bearing_only.figures import write_figures

    runs, lines = results.rows, results.curves[CURVES].values()
    tables = {
        "errors": error_table(runs),
        "behaviour": behaviour_table(runs),
        "ratios": ratio_table(runs),
        "costs": cost_table(runs, results.timings),
    }
    curves = parse_table(CURVE_HEADER + "".join(lines)) if lines else {}
    figures = write_figures(results.path / "figures", results.path, runs, curves)
    return Report.of(results.path, tables, figures)
