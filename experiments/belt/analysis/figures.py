"""Figures rebuilt from the rows of trials.csv and the error curves, and nothing else."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from matplotlib.figure import Figure

from experiments.belt.analysis.cells import cell_keys, settings_of, trackers_of
from experiments.belt.analysis.curve_figures import draw_curves, draw_error_bars
from experiments.belt.analysis.outcome_figure import draw_outcomes
from experiments.belt.analysis.success_figures import draw_matrix, draw_speed
from experiments.belt.config import TrialResult
from experiments.belt.curves import ErrorCurve
from experiments.report.style import figure_style, file_name, write_all

MOST_SETTINGS = 6
"""More pages of curves than this nobody reads; the curves themselves are in the file."""


def write_figures(
    folder: Path, results: Sequence[TrialResult], curves: Mapping[str, ErrorCurve]
) -> list[Path]:
    """Writes the figures into `folder` and returns their paths.

    Args:
        folder: Where to.
        results: The trials.
        curves: Their error curves by trial id, as far as there are any.
    """
    with figure_style():
        figures: dict[str, Figure | None] = {
            "success_vs_speed": draw_speed(results),
            "success_matrix": draw_matrix(results),
            "outcomes": draw_outcomes(results),
        }
        settings = curve_settings([row for row in results if row.trial_id in curves])
        for title, members in settings.items():
            place = [title] if len(settings) > 1 else []
            figures[file_name("error_curves", *place)] = draw_curves(title, members, curves)
            figures[file_name("error_bars", *place)] = draw_error_bars(title, members, curves)
        return write_all(folder, {name: drawn for name, drawn in figures.items() if drawn})


def curve_settings(results: Sequence[TrialResult]) -> dict[str, list[TrialResult]]:
    """Returns the settings whose error curves are drawn: at most `MOST_SETTINGS` of most trackers.

    In a sweep over many conditions these are the ones in which the control arms ran too.
    """
    settings = settings_of(results, cell_keys(results))
    counts = {title: len(trackers_of(members)) for title, members in settings.items()}
    most = max(counts.values(), default=0)
    fullest = [title for title, count in counts.items() if count == most]
    return {title: settings[title] for title in fullest[:MOST_SETTINGS]}
