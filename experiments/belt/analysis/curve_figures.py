"""Error curves of a setting: all of them with their median, and their mean with error bars."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.belt.analysis.cells import trackers_of
from experiments.belt.config import TrialResult
from experiments.belt.curves import CURVE_HZ, ErrorCurve
from experiments.report.grouping import group_by
from experiments.report.style import PAGE_WIDTH_IN, add_legend, draw_band, panels, tracker_style

MOST_SPEEDS = 4
"""Columns of a page: the lowest speed, the highest, and those between at equal steps."""

BAND_PERCENT = [10.0, 50.0, 90.0]
"""Lower edge, line and upper edge of the band."""

BAR_COUNT = 12
"""Bars of each tracker in a panel."""

_MARGIN = 1.3
"""Time axis, as a multiple of the median duration of the successes."""


def draw_curves(
    title: str, results: Sequence[TrialResult], curves: Mapping[str, ErrorCurve]
) -> Figure:
    """Draws true errors of all trials, their median and band, and the servo's own median.

    A row for each tracker, a column for each speed, as [IGPF2021] Fig. 13. Time begins at the
    object's full view; median and band are of all trials, of which those that have ended keep
    their last error.
    """
    trackers, speeds = trackers_of(results), shown_speeds(results)
    figure, axes = _panels(title, len(trackers), len(speeds))
    cells = group_by(results, ["tracker", "speed_mps"])
    for i, tracker in enumerate(trackers):
        for j, speed in enumerate(speeds):
            members = cells.get((tracker, speed), [])
            axis = axes[i][j]
            _draw_cell(axis, tracker, members, curves)
            count = f"n = {len(members)}"
            axis.text(0.97, 0.95, count, transform=axis.transAxes, ha="right", va="top")
            if i == 0:
                axis.set_title(f"{speed:.2f} m/s")
                axis.set_yscale("log")
                axis.set_ylim(1e-4, 2.0)
                axis.set_xlim(0.0, _end_s(results, speed, curves))
        axes[i][0].set_ylabel(tracker)
    figure.supylabel("pose error [m], a radian as 0.1 m", fontsize=8)
    figure.supxlabel("time in view [s]", fontsize=8)
    add_legend(figure, axes[0], columns=4)
    return figure


def draw_error_bars(
    title: str, results: Sequence[TrialResult], curves: Mapping[str, ErrorCurve]
) -> Figure:
    """Draws the mean true error of each tracker with bars of one deviation, a panel a speed.

    As [IGPF2021] Fig. 14; a trial that has ended keeps its last error.
    """
    trackers, speeds = trackers_of(results), shown_speeds(results)
    figure, axes = _panels(title, 1, len(speeds))
    cells = group_by(results, ["tracker", "speed_mps"])
    for axis, speed in zip(axes[0], speeds, strict=True):
        end_s = _end_s(results, speed, curves)
        for place, tracker in enumerate(trackers):
            members = cells.get((tracker, speed), [])
            shift_s = place / len(trackers) * end_s / BAR_COUNT
            bars_s = shift_s + np.arange(BAR_COUNT) * end_s / BAR_COUNT
            _draw_bars(axis, tracker, bars_s, members, curves)
        _draw_threshold(axis, results)
        axis.set_ylim(0.0, 0.45)
        axis.set_xlim(0.0, end_s)
        axis.set_title(f"{speed:.2f} m/s")
    axes[0][0].set_ylabel("true pose error [m]")
    figure.supxlabel("time in view [s]", fontsize=8)
    add_legend(figure, axes[0], columns=7)
    return figure


def shown_speeds(results: Sequence[TrialResult]) -> list[float]:
    """Returns at most `MOST_SPEEDS` tested speeds, the lowest and the highest among them."""
    speeds = sorted({row.speed_mps for row in results})
    places = np.linspace(0, len(speeds) - 1, min(MOST_SPEEDS, len(speeds)))
    return [speeds[round(place)] for place in places.tolist()]


def stacked(curves: Sequence[np.ndarray]) -> np.ndarray:
    """Puts curves of unequal length side by side; one that has ended keeps its last value.

    Else the trials that go on would decide alone, and these are the ones that have not grasped.

    Returns:
        (n, m) errors [m], NaN where a servo knows of no target or a trial has no curve.
    """
    errors = np.full((len(curves), max(map(len, curves), default=0)), np.nan)
    for row, curve in zip(errors, curves, strict=True):
        row[: len(curve)] = curve
        row[len(curve) :] = curve[-1] if len(curve) else np.nan
    return errors


def _end_s(
    results: Sequence[TrialResult], speed_mps: float, curves: Mapping[str, ErrorCurve]
) -> float:
    """Returns the end of the time axis: successes are seen whole, failures as long as these."""
    mine = [row for row in results if row.speed_mps == speed_mps]
    shown = [row for row in mine if row.success] or mine
    lengths = [len(curves[row.trial_id].true_m) for row in shown]
    return _MARGIN * float(np.median(lengths)) / CURVE_HZ


def _panels(title: str, rows: int, columns: int) -> tuple[Figure, list[list[Axes]]]:
    width_in = min(PAGE_WIDTH_IN, 1.2 + 2.4 * columns)
    figure, axes = panels(rows, columns, 0.9 + 1.35 * max(rows, 1.4), width_in, "col", True)
    figure.suptitle(title, x=0.995, ha="right", fontsize=8)
    return figure, axes


def _draw_cell(
    axis: Axes, tracker: str, members: Sequence[TrialResult], curves: Mapping[str, ErrorCurve]
) -> None:
    if not members:
        return
    colour, *_ = tracker_style(tracker)
    mine = [curves[row.trial_id] for row in members]
    for curve in mine:
        axis.plot(curve.time_s, curve.true_m, color=colour, linewidth=0.4, alpha=0.35)
    errors = stacked([curve.true_m for curve in mine])
    band: np.ndarray = np.percentile(errors, BAND_PERCENT, axis=0)
    low, middle, high = band
    time_s = np.arange(len(middle)) / CURVE_HZ
    draw_band(axis, time_s, low, high, colour, 0.2, label="10 to 90 %")
    axis.plot(time_s, middle, color=colour, linewidth=1.6, label="true, median")
    believed = stacked([curve.servo_m for curve in mine])
    known = np.flatnonzero(2 * np.sum(~np.isnan(believed), axis=0) >= len(mine))
    middle = np.nanmedian(believed[:, known], axis=0)
    axis.plot(known / CURVE_HZ, middle, color="black", linewidth=1.0, linestyle=(0, (3, 1.5)),
              label="the servo's own, median")  # fmt: skip
    _draw_threshold(axis, members)


def _draw_bars(
    axis: Axes,
    tracker: str,
    bars_s: np.ndarray,
    members: Sequence[TrialResult],
    curves: Mapping[str, ErrorCurve],
) -> None:
    """Draws a line with bars at its own times: those of the trackers stand side by side."""
    if not members:
        return
    errors = stacked([curves[row.trial_id].true_m for row in members])
    mean, spread = errors.mean(axis=0), errors.std(axis=0)
    chosen = np.round(bars_s * CURVE_HZ).astype(int)
    chosen = chosen[chosen < len(mean)]
    colour, marker, line = tracker_style(tracker)
    axis.plot(np.arange(len(mean)) / CURVE_HZ, mean, color=colour, linestyle=line, linewidth=1.0)
    look: dict[str, Any] = {"color": colour, "marker": marker, "linestyle": "none"}
    look |= {"markersize": 3.0, "elinewidth": 0.8, "capsize": 1.5}
    axis.errorbar(chosen / CURVE_HZ, mean[chosen], yerr=spread[chosen], label=tracker, **look)


def _draw_threshold(axis: Axes, results: Sequence[TrialResult]) -> None:
    """Draws the line below which the paper's criterion is met."""
    for threshold in sorted({row.error_threshold for row in results}):
        axis.axhline(threshold, color="black", linewidth=0.8, linestyle=":", label="threshold")
