"""Figures of bearing-only flights: how errors go with time and with the setting."""

# pyright: basic, reportArgumentType=false, reportAttributeAccessIssue=false, reportCallIssue=false, reportGeneralTypeIssues=false
# pandas is annotated in part: what a selection or a group gives is not known.

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from experiments.bearing_only.flight_figures import write_flight_figures
from experiments.bearing_only.tables import bootstrap_mean
from experiments.report.style import PAGE_WIDTH_IN, add_legend, figure_style, write_figure

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


def write_figures(
    folder: Path, source: Path, runs: pd.DataFrame, curves: pd.DataFrame
) -> list[Path]:
    """Writes what the study has; returns the paths."""
    study = str(runs["study"].iloc[0])
    with figure_style():
        if study == "speed":
            return write_figure(_error_by(runs, "v_max_mps", "v_max [m/s]"), folder, "speed")
        if study == "localisation":
            return write_figure(_error_by_pose_error(runs), folder, "localisation")
        paths: list[Path] = []
        for prior, members in runs.groupby("range_prior", sort=True):
            name = f"prior{prior:g}"
            known = curves[curves["run_id"].isin(members["run_id"])]
            if len(known):
                figure = _mean_curves(members, known)
                paths += write_figure(figure, folder, f"error_curves_{name}")
            paths += write_figure(_error_spread(members), folder, f"errors_{name}")
        return paths + write_flight_figures(folder, source, runs)


def _controllers(runs: pd.DataFrame) -> list[str]:
    return [name for name in STYLES if name in set(runs["controller"])]


def _mean_curves(runs: pd.DataFrame, curves: pd.DataFrame) -> Figure:
    """Target error, its believed deviation along the line of sight, robot error: medians."""
    merged = curves.merge(runs[["run_id", "controller"]], on="run_id")
    figure = Figure(figsize=(PAGE_WIDTH_IN, 2.7), layout="constrained")
    axes: list[Axes] = list(figure.subplots(1, 3))
    titles = (
        ("target_error_m", "error of the target [m]"),
        ("sight_std_m", "its std along the line of sight [m]"),
        ("robot_error_m", "error of the vehicle [m]"),
    )
    for axis, (column, title) in zip(axes, titles, strict=True):
        for name in _controllers(runs):
            members = merged[merged["controller"] == name].groupby("iteration")[column]
            median = members.median()
            if column == "robot_error_m" and not median.any():
                continue  # an oracle's
            colour, line = STYLES[name]
            axis.plot(median.index, median, line, color=colour, lw=1.2, label=name)
            low, high = members.quantile(0.1), members.quantile(0.9)
            if name in ("gradient", "follow"):
                axis.fill_between(median.index, low, high, color=colour, alpha=0.12, lw=0)
        axis.set_title(title)
        axis.set_xlabel("iteration")
        if column != "robot_error_m":
            axis.set_yscale("log")
            _plain_ticks(axis.yaxis)
        else:
            axis.set_ylim(bottom=0.0)
    add_legend(figure, axes, 7)
    return figure


def _error_spread(runs: pd.DataFrame) -> Figure:
    """Each flight a point, by controller; the mean as a line."""
    names = _controllers(runs)
    figure = Figure(figsize=(PAGE_WIDTH_IN, 0.8 + 0.22 * len(names)), layout="constrained")
    axes: list[Axes] = list(figure.subplots(1, 2, sharey=True))
    for axis, column, title in (
        (axes[0], "target_error_m", "mean error of the target [m]"),
        (axes[1], "robot_error_m", "mean error of the vehicle [m]"),
    ):
        for row, name in enumerate(names):
            values = runs.loc[runs["controller"] == name, column].dropna().to_numpy(float)
            if not len(values) or not values.any():
                continue
            lift = np.linspace(-0.28, 0.28, len(values))
            axis.plot(values, row + lift, ".", ms=2.5, color=STYLES[name][0], alpha=0.6)
            axis.plot([values.mean()] * 2, [row - 0.4, row + 0.4], "-", color="black", lw=1.2)
        axis.set_title(title)
        axis.set_xscale("log")
        _plain_ticks(axis.xaxis)
        axis.grid(axis="y", visible=False)
    axes[0].set_yticks(range(len(names)), names)
    axes[0].invert_yaxis()
    return figure


def _error_by(runs: pd.DataFrame, column: str, label: str) -> Figure:
    """[Wu2022] Fig. 19: mean and standard deviation over the flights by a setting."""
    figure = Figure(figsize=(PAGE_WIDTH_IN, 2.8), layout="constrained")
    axes: list[Axes] = list(figure.subplots(1, 2))
    for axis, error, title in (
        (axes[0], "target_error_m", "mean error of the target [m]"),
        (axes[1], "robot_error_m", "mean error of the vehicle [m]"),
    ):
        for name in _controllers(runs):
            _plot_error(axis, runs[runs["controller"] == name], column, error, name)
        axis.set_title(title)
        axis.set_xlabel(label)
        axis.set_ylim(bottom=0.0)
    add_legend(figure, axes, 7)
    return figure


def _error_by_pose_error(runs: pd.DataFrame) -> Figure:
    """[Wu2022] Fig. 18, once for each kind of error."""
    titles = {
        "told": "white noise, the filter knows",
        "hidden": "white noise, the filter does not know",
        "drift": "drift of that size at the end, known",
    }
    kinds = [kind for kind in titles if kind in set(runs["pose_error"])]
    figure = Figure(figsize=(PAGE_WIDTH_IN, 2.6), layout="constrained")
    axes: list[Axes] = list(figure.subplots(1, len(kinds), squeeze=False)[0])
    for axis, kind in zip(axes, kinds, strict=True):
        of_kind = runs[runs["pose_error"] == kind]
        for name in _controllers(runs):
            members = of_kind[of_kind["controller"] == name]
            _plot_error(axis, members, "pose_error_m", "target_error_m", name)
        axis.set_title(titles[kind])
        axis.set_xlabel("std of the position error [m]")
        if kind == "hidden":
            axis.set_yscale("log")
            _plain_ticks(axis.yaxis)
    axes[0].set_ylabel("mean error of the target [m]")
    add_legend(figure, axes, 7)
    return figure


def _plot_error(axis: Axes, runs: pd.DataFrame, x: str, y: str, name: str) -> None:
    """Mean, its interval as a bar and the standard deviation as a band."""
    groups = [(float(value), group[y].dropna().to_numpy(float)) for value, group in runs.groupby(x)]  # pyright: ignore[reportArgumentType]
    groups = [(value, errors) for value, errors in groups if len(errors) > 1 and errors.any()]
    if not groups:
        return
    at = [value for value, _ in groups]
    mean = np.array([errors.mean() for _, errors in groups])
    std = np.array([errors.std(ddof=1) for _, errors in groups])
    bars = np.array([bootstrap_mean(errors) for _, errors in groups]).T
    colour, line = STYLES[name]
    axis.errorbar(at, mean, [mean - bars[0], bars[1] - mean], fmt=line, color=colour, lw=1.2,
                  capsize=2, label=name)  # fmt: skip
    axis.fill_between(at, mean - std, mean + std, color=colour, alpha=0.12, lw=0)


def _plain_ticks(axis: Axis) -> None:
    """1, 2 and 5 of each decade, written out."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())
