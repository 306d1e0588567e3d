"""How the trials of each cell ended, as stacked bars."""

from collections import Counter
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from experiments.belt.analysis.cells import cell_keys, cell_sizes, title_of, trackers_of
from experiments.belt.config import TrialResult
from experiments.report.grouping import group_by, varying
from experiments.report.style import panels

OUTCOME_STYLES: dict[str, tuple[str, str]] = {
    "success": ("#DCEFE3", ""),
    "never_detected": ("#08306B", ""),
    "lost_track": ("#2E7EBC", ""),
    "left_belt": ("#A6CEE3", "////"),
    "knocked": ("#E3B23C", "xxxx"),
    "missed": ("#FE9929", "...."),
    "slipped": ("#E6701B", "||||"),
    "dropped": ("#993404", "////"),
    "collision": ("#B10026", ""),
    "infeasible_ik": ("#807DBA", "...."),
    "timeout": ("#BDBDBD", ""),
    "error": ("#000000", ""),
}
"""Colour and hatch: sight in blue, hand in orange, arm in red and violet. In grey the lightness and
the hatch of neighbours differ."""

_ROW_IN = 0.17


def draw_outcomes(results: Sequence[TrialResult]) -> Figure:
    """Draws a panel for each tracker, a bar for each setting and speed, failures on success."""
    trackers = trackers_of(results)
    names = [key for key in cell_keys(results) if key != "tracker"]
    names = varying(results, names) or ["speed_mps"]
    cells = group_by(results, names)
    height_in = max(2.0, 1.0 + _ROW_IN * len(cells))
    figure, (axes,) = panels(1, len(trackers), height_in, sharex=True, sharey=True)
    for axis, tracker in zip(axes, trackers, strict=True):
        for place, members in enumerate(cells.values()):
            _draw_bar(axis, place, [row for row in members if row.tracker == tracker])
        axis.set_title(tracker)
        axis.grid(axis="y", visible=False)
        axis.tick_params(axis="y", length=0)
    labels = [title_of(names, cell, between="  ") for cell in cells]
    axes[0].set_yticks(range(len(labels)), labels)
    axes[0].set_ylim(len(labels) - 0.4, -0.6)
    axes[0].set_xlim(0, 100)
    for axis in axes:
        axis.set_xticks([0, 50, 100])
        for text, side in zip(axis.get_xticklabels(), ("left", "center", "right"), strict=True):
            text.set_horizontalalignment(side)
    figure.supxlabel(f"trials [%], {cell_sizes(results)} a bar", fontsize=8)
    _add_legend(figure, results)
    return figure


def _draw_bar(axis: Axes, place: int, members: Sequence[TrialResult]) -> None:
    counts, left = Counter(row.outcome for row in members), 0.0
    for outcome, (colour, hatch) in OUTCOME_STYLES.items():
        share = 100 * counts[outcome] / max(len(members), 1)
        if share:
            axis.barh(place, share, 0.78, left, color=colour, hatch=hatch, edgecolor="white",
                      linewidth=0.4)  # fmt: skip
        left += share


def _add_legend(figure: Figure, results: Sequence[TrialResult]) -> None:
    present = {row.outcome for row in results}
    handles = [
        Patch(facecolor=colour, hatch=hatch, edgecolor="white", label=outcome.replace("_", " "))
        for outcome, (colour, hatch) in OUTCOME_STYLES.items()
        if outcome in present
    ]
    figure.legend(handles=handles, loc="outside upper left", ncols=min(len(handles), 6))
