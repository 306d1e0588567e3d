"""Rebuilds tables and figures of the studies of apples from their rows."""

from experiments.apple.approach import ApproachRow
from experiments.apple.estimates import EstimateRow, collect_estimates
from experiments.apple.rendered_tables import approach_tables, replay_tables
from experiments.apple.replay import ReplayRow
from experiments.apple.tables import all_tables
from experiments.report.report import Report
from experiments.study.study import Results

_SHOWN = ("agreement", "table1", "table2", "errors", "folding")


def tables_report(results: Results[EstimateRow]) -> Report:
    """Writes what came out of the published measurements."""
    from experiments.apple.figures import write_table_figures

    estimates = collect_estimates(results.good)
    figures = write_table_figures(results.path / "figures", estimates)
    return Report.of(results.path, all_tables(estimates), figures, _SHOWN, results.notes)


def replay_report(results: Results[ReplayRow]) -> Report:
    """Writes what came out of the published poses, taken again."""
    from experiments.apple.figures import write_replay_figures

    figures = write_replay_figures(results.path / "figures", results.good)
    return Report.of(results.path, replay_tables(results.good), figures, (), results.notes)


def approach_report(results: Results[ApproachRow]) -> Report:
    """Writes what came out of the approaches."""
    from experiments.apple.figures import write_approach_figures

    figures = write_approach_figures(results.path / "figures", results.good)
    return Report.of(results.path, approach_tables(results.good), figures, (), results.notes)
