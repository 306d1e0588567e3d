"""How the trials of each cell ended, as stacked bars."""

# Matplotlib leaves the types of its keyword arguments open.
# pyright: reportUnknownMemberType=false

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from experiments.belt.config import TrialResult
from experiments.report.grouping import cell_keys, group_by, label
from experiments.report.style import PAGE_WIDTH_IN, cell_sizes, trackers_of

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
    """A panel for each tracker, a bar for each setting and speed, failures on success."""
    trackers = trackers_of(results)
    names = [key for key in cell_keys(results) if key != "tracker"]
    varying = [k for k in names if len({getattr(row, k) for row in results}) > 1]
    names = varying or ["speed_mps"]
    cells = group_by(results, names)
    height = 1.0 + _ROW_IN * len(cells)
    figure = Figure(figsize=(PAGE_WIDTH_IN, max(2.0, height)), layout="constrained")
    axes: list[Axes] = list(
        figure.subplots(1, len(trackers), sharex=True, sharey=True, squeeze=False).flat
    )
    for axis, tracker in zip(axes, trackers, strict=True):
        for place, members in enumerate(cells.values()):
            _draw_bar(axis, place, [row for row in members if row.tracker == tracker])
        axis.set_title(tracker)
        axis.grid(axis="y", visible=False)
        axis.tick_params(axis="y", length=0)
    labels = [_name(names, cell) for cell in cells]
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
            axis.barh(
                place,
                share,
                0.78,
                left,
                color=colour,
                hatch=hatch,
                edgecolor="white",
                linewidth=0.4,
            )
        left += share


def _add_legend(figure: Figure, results: Sequence[TrialResult]) -> None:
    present = {row.outcome for row in results}
    handles = [
        Patch(facecolor=colour, hatch=hatch, edgecolor="white", label=outcome.replace("_", " "))
        for outcome, (colour, hatch) in OUTCOME_STYLES.items()
        if outcome in present
    ]
    figure.legend(handles=handles, loc="outside upper left", ncols=min(len(handles), 6))


def _name(names: Sequence[str], cell: tuple[Any, ...]) -> str:
    return "  ".join(label(key, value) for key, value in zip(names, cell, strict=True))
