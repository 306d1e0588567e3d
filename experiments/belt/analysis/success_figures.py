"""Success against belt speed, and over conditions, motions and trackers at a glance."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.belt.analysis.cells import (
    cell_keys,
    cell_sizes,
    label,
    settings_of,
    title_of,
    trackers_of,
)
from experiments.belt.config import TrialResult
from experiments.report.grouping import group_by, varying
from experiments.report.statistics import wilson_interval
from experiments.report.style import PAGE_WIDTH_IN, add_legend, draw_band, panel_grid, tracker_style

TRACKER_LINE = "-"
"""Others are control arms: without a band, and hollow, so that trackers show through."""

_BOUND_LABEL = "out of the arm's reach"
_PAGE_CELLS = 20
"""Cells of a matrix side by side on a page."""

_NEAR_BOUND = 0.5
"""The bound is drawn where a tested speed has at least this share of the speed where it begins."""


def draw_speed(results: Sequence[TrialResult]) -> Figure | None:
    """Draws success against belt speed, trackers with Wilson 95 % bands; None for a single speed.

    A panel for each setting. On a belt of constant speed, what the arm's joint speeds rule out for
    every method is hatched (`sim.belt.interception`).
    """
    if len({row.speed_mps for row in results}) < 2:
        return None
    settings = settings_of(results, cell_keys(results))
    width_in = PAGE_WIDTH_IN if len(settings) > 1 else 4.6
    figure, axes = panel_grid(len(settings), 3, width_in, row_in=2.3)
    for axis, (title, members) in zip(axes, settings.items(), strict=True):
        for tracker in trackers_of(results):
            _draw_rates(axis, tracker, [row for row in members if row.tracker == tracker])
        _draw_bound(axis, members)
        axis.set_title(title)
    axes[0].set_ylim(-3, 103)
    axes[0].set_xlim(left=0.0)
    figure.supxlabel("belt speed [m/s]", fontsize=8)
    figure.supylabel("successful grasps [%]", fontsize=8)
    add_legend(figure, axes, columns=7 if len(settings) > 1 else 4)
    return figure


def _draw_rates(axis: Axes, tracker: str, members: Sequence[TrialResult]) -> None:
    if not members:
        return
    cells = sorted(group_by(members, ["speed_mps"]).items())
    speeds = [speed for (speed,), _ in cells]
    counts = [(sum(row.success for row in rows), len(rows)) for _, rows in cells]
    low, high = np.array([wilson_interval(*count) for count in counts]).T
    colour, marker, line = tracker_style(tracker)
    if line == TRACKER_LINE:
        draw_band(axis, speeds, 100 * low, 100 * high, colour)
        look: dict[str, Any] = {"markersize": 4.0, "markerfacecolor": colour, "zorder": 3}
    else:
        look = {"markersize": 7.0, "markerfacecolor": "none", "zorder": 2}
    rates = [100 * successes / n for successes, n in counts]
    axis.plot(speeds, rates, marker + line, color=colour, linewidth=1.2, label=tracker, **look)


def _draw_bound(axis: Axes, members: Sequence[TrialResult]) -> None:
    """Hatches the rates that no method can have, where the tested speeds come near."""
    (first, *_) = members
    if first.motion != "constant":
        return
    from sim.arm.embodiments import get_embodiment
    from sim.belt.interception import closing_time_s, interceptable_share
    from sim.belt.objects import get_object
    from sim.belt.scenario import ScenarioRange

    spec, embodiment = get_object(first.object), get_embodiment(first.embodiment)
    _, width_m, height_m = spec.size_m
    speeds = np.linspace(0.0, 3.0, 301)
    share = interceptable_share(
        embodiment,
        speeds,
        ScenarioRange().offset_m,
        height_m - spec.grasp_depth_m,
        closing_time_s(embodiment.gripper, width_m, first.gripper_delay_s),
    )
    starts, ends = speeds[share < 1.0][0], speeds[share <= 0.0][0]
    if max(row.speed_mps for row in members) < _NEAR_BOUND * starts:
        return
    shown = (speeds >= starts - 0.01) & (speeds <= ends + 0.1)
    axis.fill_between(speeds[shown], 100 * share[shown], 110.0, facecolor="none", hatch="////",
                      edgecolor="#9A9A9A", linewidth=0.8, label=_BOUND_LABEL)  # fmt: skip
    axis.set_xlim(right=ends + 0.1)


def draw_matrix(results: Sequence[TrialResult]) -> Figure | None:
    """Draws success rates as numbers on colour; None where only tracker and speed vary.

    A column for each tracker, a row for each value of what has most values (mostly the condition,
    the easiest above), a panel for each combination of the rest, as speed and motion.
    """
    others = [k for k in cell_keys(results) if k not in ("tracker", "speed_mps")]
    value_count = {key: len({getattr(row, key) for row in results}) for key in others}
    row_key = max(others, key=value_count.__getitem__)
    if value_count[row_key] < 2:
        return None
    panel_keys = [k for k in (*others, "speed_mps") if k != row_key]
    panels = group_by(results, panel_keys)
    values = dict.fromkeys(getattr(row, row_key) for row in results)
    rows = sorted(values, key=_ease(results, row_key))
    trackers = trackers_of(results)
    columns = max(1, _PAGE_CELLS // len(trackers))
    figure, axes = panel_grid(len(panels), columns, PAGE_WIDTH_IN, row_in=0.6 + 0.2 * len(rows))
    titled = varying(results, panel_keys)
    for axis, members in zip(axes, panels.values(), strict=True):
        cells = group_by(members, [row_key, "tracker"])
        _draw_cells(axis, [[cells.get((row, t), []) for t in trackers] for row in rows])
        axis.set_title(title_of(titled, [getattr(members[0], key) for key in titled]))
        axis.tick_params(axis="x", rotation=90)
    axes[0].set_yticks(range(len(rows)), [label(row_key, row) for row in rows])
    axes[0].set_xticks(range(len(trackers)), trackers)
    figure.supxlabel(f"successful grasps [%], {cell_sizes(results)} a cell", fontsize=8)
    return figure


def _ease(results: Sequence[TrialResult], row_key: str) -> Callable[[Any], float]:
    """Returns a sort key: values of `row_key` by their success, the highest first."""
    rates = {
        value: -sum(row.success for row in members) / len(members)
        for (value,), members in group_by(results, [row_key]).items()
    }
    return rates.__getitem__


def _rate(rows: Sequence[TrialResult]) -> float:
    return 100 * sum(row.success for row in rows) / len(rows) if rows else math.nan


def _draw_cells(axis: Axes, cells: Sequence[Sequence[Sequence[TrialResult]]]) -> None:
    rates = np.array([[_rate(rows) for rows in line] for line in cells])
    axis.imshow(rates, cmap=colormaps["cividis_r"], vmin=0.0, vmax=100.0, aspect="auto")
    axis.grid(visible=False)
    axis.tick_params(length=0)
    for (i, j), rate in np.ndenumerate(rates):
        if not np.isnan(rate):
            colour = "white" if rate > 55 else "black"
            axis.text(j, i, f"{rate:.0f}", ha="center", va="center", color=colour, fontsize=7)
