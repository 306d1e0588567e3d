"""Figures of single flights: the ways in the room, the parts of the command, the errors.

They are the counterparts of [Wu2022] Figs. 6, 11 to 17 and 20, drawn from the flights with seed 0
that a study keeps whole.
"""

# pyright: basic, reportArgumentType=false, reportAttributeAccessIssue=false, reportCallIssue=false, reportGeneralTypeIssues=false
# pandas is annotated in part: what a selection or a group gives is not known.

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from matplotlib.ticker import MaxNLocator

from experiments.bearing_only.config import FlightRun
from experiments.bearing_only.traces import TRACED, TRACED_SEED, TRACES, trace_name
from experiments.report.style import PAGE_WIDTH_IN, add_legend, write_figure

ROBOT, TARGET, LANDMARK = "#0072B2", "#D55E00", "#7F7F7F"
_ELLIPSES = 7
"""Moments at which the target's covariance is drawn."""


def write_flight_figures(folder: Path, source: Path, runs: pd.DataFrame) -> list[Path]:
    """Draws the flights that were kept; returns the paths."""
    paths: list[Path] = []
    first = runs[runs["seed"] == TRACED_SEED].drop_duplicates(["controller", "range_prior"])
    for prior, members in first.groupby("range_prior", sort=True):
        flights: dict[str, pd.DataFrame] = {}
        maps: dict[str, pd.DataFrame] = {}
        for row in members.itertuples():
            run = FlightRun(
                row.study, row.controller, v_max_mps=row.v_max_mps, range_prior=row.range_prior
            )  # pyright: ignore[reportArgumentType]
            path = source / TRACES / f"{trace_name(run)}.csv"
            if row.controller in TRACED and path.exists():
                flights[row.controller] = pd.read_csv(path)
                map_path = path.with_name(f"{path.stem}_map.csv")
                if map_path.exists():
                    maps[row.controller] = pd.read_csv(map_path)
        if flights:
            paths += _write(folder, f"prior{prior:g}", flights, maps)
    return paths


def _write(
    folder: Path, name: str, flights: dict[str, pd.DataFrame], maps: dict[str, pd.DataFrame]
) -> list[Path]:
    ordered = {key: flights[key] for key in TRACED if key in flights}
    paths = write_figure(_top_views(ordered, maps), folder, f"top_view_{name}")
    paths += write_figure(_paths_3d(ordered), folder, f"path_3d_{name}")
    paths += write_figure(_controls(ordered), folder, f"control_{name}")
    return paths + write_figure(_errors(ordered), folder, f"flight_errors_{name}")


def _top_views(flights: dict[str, pd.DataFrame], maps: dict[str, pd.DataFrame]) -> Figure:
    """[Wu2022] Figs. 6, 11, 16 and 20: ways, estimates, landmarks and covariances from above."""
    figure = Figure(figsize=(PAGE_WIDTH_IN, 3.1), layout="constrained")
    axes: list[Axes] = list(figure.subplots(1, len(flights), squeeze=False)[0])
    for axis, (name, flight) in zip(axes, flights.items(), strict=True):
        if name in maps:
            _draw_map(axis, maps[name])
        _draw_way(axis, flight, "robot", ROBOT)
        _draw_way(axis, flight, "target", TARGET)
        _draw_target_ellipses(axis, flight)
        axis.set_title(name)
        axis.set_aspect("equal")
        axis.set_xlabel("x [m]")
        _frame(axis, flight)
    axes[0].set_ylabel("y [m]")
    add_legend(figure, axes, 6)
    return figure


def _frame(axis: Axes, flight: pd.DataFrame) -> None:
    """Limits around the true ways, wide enough to see what is beside them."""
    for set_limits, letter in ((axis.set_xlim, "x"), (axis.set_ylim, "y")):
        values = flight[[f"robot_{letter}_m", f"target_{letter}_m"]].to_numpy()
        middle = 0.5 * (values.min() + values.max())
        set_limits(middle - _half(flight), middle + _half(flight))


def _half(flight: pd.DataFrame) -> float:
    spans = [np.ptp(flight[[f"robot_{a}_m", f"target_{a}_m"]].to_numpy()) for a in "xy"]
    return 0.62 * float(max(spans))


def _draw_map(axis: Axes, landmarks: pd.DataFrame) -> None:
    axis.plot(landmarks["x_m"], landmarks["y_m"], "+", ms=3, mew=0.6, color=LANDMARK,
              label="landmark")  # fmt: skip
    for row in landmarks.to_dict("records"):
        P = _block(row, "covariance")
        centre = (row["estimate_x_m"], row["estimate_y_m"])
        axis.add_patch(_ellipse(centre, P, edgecolor=LANDMARK, lw=0.4, alpha=0.6))


def _draw_target_ellipses(axis: Axes, flight: pd.DataFrame) -> None:
    for row in flight.iloc[:: max(len(flight) // _ELLIPSES, 1)].to_dict("records"):
        centre = (row["target_estimate_x_m"], row["target_estimate_y_m"])
        P = _block(row, "target_covariance")
        axis.add_patch(_ellipse(centre, P, edgecolor=TARGET, lw=0.7, alpha=0.9))


def _block(row: dict[str, float], name: str) -> np.ndarray:
    xx, xy, yy = (row[f"{name}_{pair}_m2"] for pair in ("xx", "xy", "yy"))
    return np.array([[xx, xy], [xy, yy]])


def _ellipse(centre: tuple[float, float], P: np.ndarray, **style: object) -> Ellipse:
    """Two standard deviations of a (2, 2) covariance."""
    values, vectors = np.linalg.eigh(P)
    width, height = 4.0 * np.sqrt(np.maximum(values, 0.0))
    angle = np.degrees(np.arctan2(vectors[1, 0], vectors[0, 0]))
    return Ellipse(centre, width, height, angle=angle, fill=False, **style)  # pyright: ignore[reportArgumentType]


def _draw_way(axis: Axes, flight: pd.DataFrame, who: str, colour: str) -> None:
    label = {"robot": "vehicle", "target": "target"}[who]
    axis.plot(flight[f"{who}_x_m"], flight[f"{who}_y_m"], "-", color=colour, lw=1.2, label=label)
    axis.plot(flight[f"{who}_estimate_x_m"], flight[f"{who}_estimate_y_m"], "--", color="black",
              lw=0.7, label="estimates")  # fmt: skip
    axis.plot(flight[f"{who}_x_m"].iloc[0], flight[f"{who}_y_m"].iloc[0], "o", ms=4, color=colour)


def _paths_3d(flights: dict[str, pd.DataFrame]) -> Figure:
    """[Wu2022] Fig. 12: the ways in space."""
    figure = Figure(figsize=(PAGE_WIDTH_IN, 2.5))
    figure.subplots_adjust(left=0.0, right=0.97, bottom=0.06, top=0.92, wspace=0.12)
    for index, (name, flight) in enumerate(flights.items()):
        axis = figure.add_subplot(1, len(flights), index + 1, projection="3d")
        for who, colour in (("robot", ROBOT), ("target", TARGET)):
            way = [flight[f"{who}_{letter}_m"].to_numpy() for letter in "xyz"]
            guess = [flight[f"{who}_estimate_{letter}_m"].to_numpy() for letter in "xyz"]
            axis.plot(*way, color=colour, lw=1.0)
            if who == "robot":
                axis.plot(*guess, "--", color="black", lw=0.6)
        axis.set_title(f"{name}; height z upward [m]", y=0.97)
        axis.tick_params(labelsize=6, pad=-3)
        for letter in "xyz":
            getattr(axis, f"{letter}axis").set_major_locator(MaxNLocator(4))
        axis.set_xlabel("x [m]", labelpad=-8, fontsize=7)
        axis.set_ylabel("y [m]", labelpad=-8, fontsize=7)
        axis.set_box_aspect((1.0, 1.0, 0.7))
    return figure


def _controls(flights: dict[str, pd.DataFrame]) -> Figure:
    """[Wu2022] Figs. 13 and 15: the parts of the command, and the innovation's ellipse."""
    figure, rows = _rows(2)
    moving = {key: flight for key, flight in flights.items() if key != "follow"} or flights
    styles = dict(zip(flights, ("-", "--", ":"), strict=False))
    for name, flight in moving.items():
        aside = np.linalg.norm(flight[[f"aside_{a}_mps" for a in "xyz"]], axis=1)
        total = np.linalg.norm(flight[[f"command_{a}_mps" for a in "xyz"]], axis=1)
        line = styles[name]
        rows[0].plot(total, line, color="black", lw=0.8, label=f"speed, {name}")
        rows[0].plot(flight["follow_mps"], line, color=ROBOT, lw=1.2, label=f"following, {name}")
        rows[0].plot(aside, line, color=TARGET, lw=1.2, label=f"observability, {name}")
    for (name, flight), colour in zip(flights.items(), (ROBOT, LANDMARK, TARGET), strict=False):
        rows[1].plot(flight["innovation_area_px2"], color=colour, lw=1.0, label=f"ellipse, {name}")
    rows[0].set_title("speeds of the command [m/s]")
    rows[1].set_title("area of the target's innovation ellipse, one std [px²]")
    rows[1].set_xlabel("iteration")
    add_legend(figure, rows, 4)
    return figure


def _errors(flights: dict[str, pd.DataFrame]) -> Figure:
    """[Wu2022] Figs. 14 and 17: errors by axis and in all, of target and vehicle."""
    figure = Figure(figsize=(PAGE_WIDTH_IN, 3.4), layout="constrained")
    grid = figure.subplots(2, len(flights), sharex=True, sharey="row", squeeze=False)
    colours = ("#0072B2", "#009E73", "#CC79A7")
    for column, (name, flight) in enumerate(flights.items()):
        for axis, who in zip(grid[:, column], ("target", "robot"), strict=True):
            e = np.stack([flight[f"{who}_estimate_{a}_m"] - flight[f"{who}_{a}_m"] for a in "xyz"])
            for values, letter, colour in zip(e, "xyz", colours, strict=True):
                axis.plot(values, color=colour, lw=0.7, label=letter)
            axis.plot(np.linalg.norm(e, axis=0), color="black", lw=1.2, label="distance")
            if who == "robot":
                reckoned = [flight[f"reckoned_{a}_m"] - flight[f"robot_{a}_m"] for a in "xyz"]
                axis.plot(np.linalg.norm(reckoned, axis=0), "--", color=LANDMARK, lw=1.0,
                          label="dead reckoning")  # fmt: skip
        grid[0, column].set_title(name)
        grid[1, column].set_xlabel("iteration")
    grid[0, 0].set_ylabel("error of the target [m]")
    grid[1, 0].set_ylabel("error of the vehicle [m]")
    add_legend(figure, list(grid.flat), 5)
    return figure


def _rows(count: int) -> tuple[Figure, Sequence[Axes]]:
    figure = Figure(figsize=(PAGE_WIDTH_IN, 1.8 * count), layout="constrained")
    return figure, list(figure.subplots(count, 1, sharex=True))
