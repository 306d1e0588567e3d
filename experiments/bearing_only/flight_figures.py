"""Figures of single flights: the ways in the room, the parts of the command, the errors.

They are the counterparts of [Wu2022] Figs. 6, 11 to 17 and 20, drawn from the flights with seed 0
that a study keeps whole.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from matplotlib.ticker import MaxNLocator

from experiments.bearing_only.config import FlightResult
from experiments.bearing_only.traces import TRACED, TRACED_SEED, TRACES, read_table, trace_name
from experiments.report.grouping import group_by
from experiments.report.style import PAGE_WIDTH_IN, add_legend, panels, write_all

ROBOT, TARGET, LANDMARK = "#0072B2", "#D55E00", "#7F7F7F"
_ELLIPSES = 7
"""Moments at which the target's covariance is drawn."""

Flight: TypeAlias = Mapping[str, np.ndarray]
"""Columns of a flight that was kept whole, one value for each iteration."""


def write_flight_figures(folder: Path, source: Path, runs: Sequence[FlightResult]) -> list[Path]:
    """Draws the flights that were kept in the results folder `source` and returns the paths."""
    paths: list[Path] = []
    first = [run for run in runs if run.seed == TRACED_SEED]
    for (prior,), members in sorted(group_by(first, ["range_prior"]).items()):
        names = {run.controller: trace_name(run) for run in reversed(members)}
        flights = {
            key: flight
            for key in TRACED
            if key in names and (flight := read_table(source / TRACES / f"{names[key]}.csv"))
        }
        maps = {key: read_table(source / TRACES / f"{names[key]}_map.csv") for key in flights}
        if flights:
            figures = {
                "top_view": _top_views(flights, maps),
                "path_3d": _paths_3d(flights),
                "control": _controls(flights),
                "flight_errors": _errors(flights),
            }
            paths += write_all(folder, {f"{n}_prior{prior:g}": f for n, f in figures.items()})
    return paths


def _top_views(flights: Mapping[str, Flight], maps: Mapping[str, Flight]) -> Figure:
    """Draws ways, estimates, landmarks, covariances from above: [Wu2022] Figs. 6, 11, 16, 20."""
    figure, (axes,) = panels(1, len(flights), 3.1)
    for axis, (name, flight) in zip(axes, flights.items(), strict=True):
        if maps[name]:
            _draw_map(axis, maps[name])
        _draw_way(axis, flight, "robot", "vehicle", ROBOT)
        _draw_way(axis, flight, "target", "target", TARGET)
        steps = range(0, len(flight["robot_x_m"]), max(len(flight["robot_x_m"]) // _ELLIPSES, 1))
        _draw_ellipses(axis, flight, "target_", steps, edgecolor=TARGET, lw=0.7, alpha=0.9)
        axis.set_title(name)
        axis.set_aspect("equal")
        axis.set_xlabel("x [m]")
        _frame(axis, flight)
    axes[0].set_ylabel("y [m]")
    add_legend(figure, axes, 6)
    return figure


def _frame(axis: Axes, flight: Flight) -> None:
    """Sets limits around the true ways, wide enough to see what is beside them."""
    x, y = (np.concatenate([flight[f"{who}_{a}_m"] for who in ("robot", "target")]) for a in "xy")
    half = 0.62 * max(float(np.ptp(x)), float(np.ptp(y)))
    for set_limits, values in ((axis.set_xlim, x), (axis.set_ylim, y)):
        middle = 0.5 * (values.min() + values.max())
        set_limits(middle - half, middle + half)


def _draw_map(axis: Axes, landmarks: Flight) -> None:
    axis.plot(landmarks["x_m"], landmarks["y_m"], "+", ms=3, mew=0.6, color=LANDMARK,
              label="landmark")  # fmt: skip
    places = range(len(landmarks["x_m"]))
    _draw_ellipses(axis, landmarks, "", places, edgecolor=LANDMARK, lw=0.4, alpha=0.6)


def _draw_ellipses(
    axis: Axes, columns: Flight, prefix: str, places: Sequence[int], **style: Any
) -> None:
    """Draws two standard deviations of some estimates in x and y."""
    for k in places:
        x, y = (columns[f"{prefix}estimate_{a}_m"][k] for a in "xy")
        xx, xy, yy = (columns[f"{prefix}covariance_{pair}_m2"][k] for pair in ("xx", "xy", "yy"))
        values, vectors = np.linalg.eigh(np.array([[xx, xy], [xy, yy]]))
        width, height = 4.0 * np.sqrt(np.maximum(values, 0.0))
        angle = np.degrees(np.arctan2(vectors[1, 0], vectors[0, 0]))
        axis.add_patch(Ellipse((x, y), width, height, angle=angle, fill=False, **style))


def _draw_way(axis: Axes, flight: Flight, who: str, label: str, colour: str) -> None:
    x, y = flight[f"{who}_x_m"], flight[f"{who}_y_m"]
    axis.plot(x, y, "-", color=colour, lw=1.2, label=label)
    axis.plot(flight[f"{who}_estimate_x_m"], flight[f"{who}_estimate_y_m"], "--", color="black",
              lw=0.7, label="estimates")  # fmt: skip
    axis.plot(x[0], y[0], "o", ms=4, color=colour)


def _paths_3d(flights: Mapping[str, Flight]) -> Figure:
    """Draws the ways in space, as [Wu2022] Fig. 12."""
    figure = Figure(figsize=(PAGE_WIDTH_IN, 2.5))
    figure.subplots_adjust(left=0.0, right=0.97, bottom=0.06, top=0.92, wspace=0.12)
    for index, (name, flight) in enumerate(flights.items()):
        axis: Any = figure.add_subplot(1, len(flights), index + 1, projection="3d")
        for who, colour in (("robot", ROBOT), ("target", TARGET)):
            axis.plot(*_xyz(flight, f"{who}_{{}}_m"), color=colour, lw=1.0)
            if who == "robot":
                guess = _xyz(flight, "robot_estimate_{}_m")
                axis.plot(*guess, "--", color="black", lw=0.6)
        axis.set_title(f"{name}; height z upward [m]", y=0.97)
        axis.tick_params(labelsize=6, pad=-3)
        for letter in "xyz":
            getattr(axis, f"{letter}axis").set_major_locator(MaxNLocator(4))
        axis.set_xlabel("x [m]", labelpad=-8, fontsize=7)
        axis.set_ylabel("y [m]", labelpad=-8, fontsize=7)
        axis.set_box_aspect((1.0, 1.0, 0.7))
    return figure


def _controls(flights: Mapping[str, Flight]) -> Figure:
    """Draws the parts of the command, and the innovation's ellipse: [Wu2022] Figs. 13, 15."""
    figure, ((speeds,), (areas,)) = panels(2, 1, 3.6, sharex=True)
    moving = {key: flight for key, flight in flights.items() if key != "follow"} or flights
    styles = dict(zip(flights, ("-", "--", ":"), strict=False))
    for name, flight in moving.items():
        aside, total = (np.linalg.norm(_xyz(flight, f"{n}_{{}}_mps"), axis=0)
                        for n in ("aside", "command"))  # fmt: skip
        line = styles[name]
        speeds.plot(total, line, color="black", lw=0.8, label=f"speed, {name}")
        speeds.plot(flight["follow_mps"], line, color=ROBOT, lw=1.2, label=f"following, {name}")
        speeds.plot(aside, line, color=TARGET, lw=1.2, label=f"observability, {name}")
    for (name, flight), colour in zip(flights.items(), (ROBOT, LANDMARK, TARGET), strict=False):
        areas.plot(flight["innovation_area_px2"], color=colour, lw=1.0, label=f"ellipse, {name}")
    speeds.set_title("speeds of the command [m/s]")
    areas.set_title("area of the target's innovation ellipse, one std [px²]")
    areas.set_xlabel("iteration")
    add_legend(figure, (speeds, areas), 4)
    return figure


def _errors(flights: Mapping[str, Flight]) -> Figure:
    """Draws errors by axis and in all, of target and vehicle, as [Wu2022] Figs. 14 and 17."""
    figure, rows = panels(2, len(flights), 3.4, sharex=True, sharey="row")
    colours = ("#0072B2", "#009E73", "#CC79A7")
    for who, axes in zip(("target", "robot"), rows, strict=True):
        for axis, flight in zip(axes, flights.values(), strict=True):
            true_m = _xyz(flight, f"{who}_{{}}_m")
            error_m = _xyz(flight, f"{who}_estimate_{{}}_m") - true_m
            for values, letter, colour in zip(error_m, "xyz", colours, strict=True):
                axis.plot(values, color=colour, lw=0.7, label=letter)
            axis.plot(np.linalg.norm(error_m, axis=0), color="black", lw=1.2, label="distance")
            if who == "robot":
                reckoned = np.linalg.norm(_xyz(flight, "reckoned_{}_m") - true_m, axis=0)
                axis.plot(reckoned, "--", color=LANDMARK, lw=1.0, label="dead reckoning")
    for name, above, below in zip(flights, *rows, strict=True):
        above.set_title(name)
        below.set_xlabel("iteration")
    rows[0][0].set_ylabel("error of the target [m]")
    rows[1][0].set_ylabel("error of the vehicle [m]")
    add_legend(figure, [axis for axes in rows for axis in axes], 5)
    return figure


def _xyz(flight: Flight, name: str) -> np.ndarray:
    """(3, n) columns of a flight, whose name has the letter of the axis in its braces."""
    return np.stack([flight[name.format(axis)] for axis in "xyz"])
