"""Figures of bearing-only flights: how errors go with time and with the setting."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.bearing_only.config import FlightResult
from experiments.bearing_only.flight_figures import write_flight_figures
from experiments.bearing_only.tables import column_of
from experiments.report.grouping import group_by
from experiments.report.statistics import bootstrap, mean
from experiments.report.style import (
    add_legend,
    draw_band,
    figure_style,
    log_scale,
    panels,
    write_figure,
)
from experiments.seeding import Stream, generator

STYLES: dict[str, tuple[str, str]] = {
    "published": ("#8C6D31", "-"),
    "gradient": ("#0072B2", "-"),
    "gradient-floor": ("#56B4E9", "-"),
    "log-det": ("#009E73", "-"),
    "cubature": ("#1B9E77", "--"),
    "mixture": ("#E69F00", "-"),
    "turn": ("#D55E00", "-"),
    "follow": ("#7F7F7F", "-"),
    "random": ("#CC79A7", "-"),
    "dead-reckoning": ("#6A3D9A", "-"),
    "known-pose": ("#0072B2", ":"),
    "known-pose-published": ("#8C6D31", ":"),
    "fused-pose": ("#009E73", ":"),
    "known-pose-log-det": ("#009E73", ":"),
    "known-pose-cubature": ("#CC79A7", ":"),
    "known-pose-mixture": ("#E69F00", ":"),
    "known-pose-turn": ("#D55E00", ":"),
}
"""Colour and line of each controller; oracles are dotted."""


_ERRORS = {
    "target_error_m": "mean error of the target [m]",
    "robot_error_m": "mean error of the vehicle [m]",
}
"""Columns of runs.csv, and titles of their panels."""


def write_figures(
    folder: Path,
    source: Path,
    runs: Sequence[FlightResult],
    curves: Mapping[str, np.ndarray],
) -> list[Path]:
    """Writes what the study has into `folder` and returns the paths.

    Args:
        folder: Where to.
        source: The results folder, which holds the flights that were kept whole.
        runs: Its flights.
        curves: Columns of its error curves; empty where it has none.
    """
    with figure_style():
        if runs[0].study == "speed":
            return write_figure(_error_by_speed(runs), folder, "speed")
        if runs[0].study == "localisation":
            return write_figure(_error_by_pose_error(runs), folder, "localisation")
        paths: list[Path] = []
        for (prior,), members in sorted(group_by(runs, ["range_prior"]).items()):
            name = f"prior{prior:g}"
            if np.isin([run.run_id for run in members], curves.get("run_id", [])).any():
                figure = _median_curves(members, curves)
                paths += write_figure(figure, folder, f"error_curves_{name}")
            paths += write_figure(_error_spread(members), folder, f"errors_{name}")
        return paths + write_flight_figures(folder, source, runs)


def _by_controller(runs: Sequence[FlightResult]) -> dict[str, list[FlightResult]]:
    groups = group_by(runs, ["controller"])
    return {name: groups[(name,)] for name in STYLES if (name,) in groups}


def _median_curves(runs: Sequence[FlightResult], curves: Mapping[str, np.ndarray]) -> Figure:
    """Draws medians of the target error, its std along the line of sight, the vehicle's error."""
    figure, (axes,) = panels(1, 3, 2.7)
    titles = {
        "target_error_m": "error of the target [m]",
        "sight_std_m": "its std along the line of sight [m]",
        "robot_error_m": "error of the vehicle [m]",
    }
    for axis, (column, title) in zip(axes, titles.items(), strict=True):
        for name, members in _by_controller(runs).items():
            of_runs = np.isin(curves["run_id"], [run.run_id for run in members])
            iteration, values = curves["iteration"][of_runs], curves[column][of_runs]
            at = np.unique(iteration)
            if not len(at) or (column == "robot_error_m" and not values.any()):
                continue  # an oracle's
            band = [np.nanpercentile(values[iteration == k], [10.0, 50.0, 90.0]) for k in at]
            low, median, high = np.array(band).T
            colour, line = STYLES[name]
            axis.plot(at, median, line, color=colour, lw=1.2, label=name)
            if name in ("gradient", "follow"):
                draw_band(axis, at, low, high, colour, 0.12)
        axis.set_title(title)
        axis.set_xlabel("iteration")
        if column != "robot_error_m":
            log_scale(axis, "y")
        else:
            axis.set_ylim(bottom=0.0)
    add_legend(figure, axes, 7)
    return figure


def _error_spread(runs: Sequence[FlightResult]) -> Figure:
    """Draws each flight as a point, by controller, and the mean as a line."""
    groups = _by_controller(runs)
    figure, (axes,) = panels(1, 2, 0.8 + 0.22 * len(groups), sharey=True)
    for axis, (column, title) in zip(axes, _ERRORS.items(), strict=True):
        for row, (name, members) in enumerate(groups.items()):
            values = column_of(members, column)
            if not values.any():
                continue
            lift = np.linspace(-0.28, 0.28, len(values))
            axis.plot(values, row + lift, ".", ms=2.5, color=STYLES[name][0], alpha=0.6)
            axis.plot([values.mean()] * 2, [row - 0.4, row + 0.4], "-", color="black", lw=1.2)
        axis.set_title(title)
        log_scale(axis, "x")
        axis.grid(axis="y", visible=False)
    axes[0].set_yticks(range(len(groups)), list(groups))
    axes[0].invert_yaxis()
    return figure


def _error_by_speed(runs: Sequence[FlightResult]) -> Figure:
    """Draws mean and standard deviation over the flights by speed, as [Wu2022] Fig. 19."""
    figure, (axes,) = panels(1, 2, 2.8)
    for axis, (error, title) in zip(axes, _ERRORS.items(), strict=True):
        for name, members in _by_controller(runs).items():
            _plot_error(axis, members, "v_max_mps", error, name)
        axis.set_title(title)
        axis.set_xlabel("v_max [m/s]")
        axis.set_ylim(bottom=0.0)
    add_legend(figure, axes, 7)
    return figure


def _error_by_pose_error(runs: Sequence[FlightResult]) -> Figure:
    """Draws errors by the error of the known pose, as [Wu2022] Fig. 18, once for each kind."""
    titles = {
        "told": "white noise, the filter knows",
        "hidden": "white noise, the filter does not know",
        "drift": "drift of that size at the end, known",
    }
    groups = group_by(runs, ["pose_error"])
    kinds = [kind for kind in titles if (kind,) in groups]
    figure, (axes,) = panels(1, len(kinds), 2.6)
    for axis, kind in zip(axes, kinds, strict=True):
        for name, members in _by_controller(groups[(kind,)]).items():
            _plot_error(axis, members, "pose_error_m", "target_error_m", name)
        axis.set_title(titles[kind])
        axis.set_xlabel("std of the position error [m]")
        if kind == "hidden":
            log_scale(axis, "y")
    axes[0].set_ylabel("mean error of the target [m]")
    add_legend(figure, axes, 7)
    return figure


def _plot_error(axis: Axes, runs: Sequence[FlightResult], x: str, y: str, name: str) -> None:
    """Draws means with their intervals as bars and the standard deviation as a band."""
    groups = {at: column_of(own, y) for (at,), own in sorted(group_by(runs, [x]).items())}
    groups = {at: errors for at, errors in groups.items() if len(errors) > 1 and errors.any()}
    if not groups:
        return
    std = np.array([errors.std(ddof=1) for errors in groups.values()])
    found = [bootstrap(mean, generator(0, Stream.BOOTSTRAP), own) for own in groups.values()]
    middle, low, high = np.array(found).T
    colour, line = STYLES[name]
    at = list(groups)
    axis.errorbar(at, middle, [middle - low, high - middle], fmt=line, color=colour, lw=1.2,
                  capsize=2, label=name)  # fmt: skip
    draw_band(axis, at, middle - std, middle + std, colour, 0.12)
