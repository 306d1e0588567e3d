"""An animation of one flight: the room from above, what the camera sees, and the error so far."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from numpy.typing import NDArray

from experiments.bearing_only.config import FlightRun
from experiments.bearing_only.flying import FlightLog, fly
from experiments.bearing_only.studies import world_of
from experiments.figure_style import figure_style
from experiments.movie import Movie

FRAME_HZ = 20
EVERY = 2
"""Iterations to a frame: twice the speed of the flight outdoors."""
_ROBOT, _TARGET, _INK = "#0072B2", "#D55E00", "#333333"
_TAIL = 60
"""Iterations of the way that stay in the picture."""


def film(run: FlightRun, folder: Path) -> Path:
    """Flies the run again and writes CONTROLLER_seedN.mp4; the path."""
    log = fly([run]).log
    path = folder / f"{run.study}_{run.controller}_seed{run.seed}.mp4"
    with figure_style(), Movie(path, FRAME_HZ) as movie:
        figure = Figure(figsize=(9.6, 5.4), dpi=100)
        canvas = FigureCanvasAgg(figure)
        for k in range(0, len(log.is_seen), EVERY):
            _draw(figure, run, log, k)
            canvas.draw()
            movie.add(np.asarray(canvas.buffer_rgba())[..., :3])
    if movie.is_empty:
        raise ValueError(f"there is nothing to film: {run.controller} never saw the target")
    return path


def _draw(figure: Figure, run: FlightRun, log: FlightLog, k: int) -> None:
    """One frame: the room on the left, errors on the right."""
    figure.clear()
    figure.suptitle(f"{run.study}  {run.controller}  seed {run.seed}  iteration {k}", fontsize=9)
    room = figure.add_axes((0.06, 0.09, 0.52, 0.82))
    _draw_room(room, run, log, k)
    errors = figure.add_axes((0.66, 0.56, 0.32, 0.33))
    _draw_errors(errors, log, k)
    speeds = figure.add_axes((0.66, 0.11, 0.32, 0.33))
    _draw_speeds(speeds, log, k)


def _draw_room(axis: Axes, run: FlightRun, log: FlightLog, k: int) -> None:
    config = world_of(run)
    (low_x, low_y, _), (high_x, high_y, _) = config.landmark_low_m, config.landmark_high_m
    axis.set(xlim=(low_x, high_x), ylim=(low_y, high_y), aspect="equal")
    axis.set_xlabel("x [m]")
    axis.set_ylabel("y [m]")
    tail = slice(max(0, k - _TAIL), k + 1)
    for truth, estimate, colour, name in (
        ("robot_m", "robot_estimate_m", _ROBOT, "vehicle"),
        ("target_m", "target_estimate_m", _TARGET, "target"),
    ):
        way, guess = log.array(truth)[:, 0], log.array(estimate)[:, 0]
        axis.plot(*way[tail, :2].T, "-", color=colour, lw=1.5, label=name)
        axis.plot(*guess[tail, :2].T, "--", color=_INK, lw=0.8)
        axis.plot(*way[k, :2], "o", color=colour, ms=6)
        axis.plot(*guess[k, :2], "x", color=_INK, ms=6)
    sight = np.stack([log.array("robot_m")[k, 0, :2], log.array("target_m")[k, 0, :2]]).T
    axis.plot(*sight, ":", color=_INK, lw=0.7)
    P, centre = log.array("target_covariance")[k, 0], log.array("target_estimate_m")[k, 0]
    axis.add_patch(_ellipse(centre, P))
    axis.legend(loc="lower left")


def _ellipse(centre: NDArray[np.float64], P: NDArray[np.float64]) -> Ellipse:
    """Two standard deviations of the target's position, from above."""
    values, vectors = np.linalg.eigh(P[:2, :2])
    width, height = 4.0 * np.sqrt(np.maximum(values, 0.0))
    angle = float(np.degrees(np.arctan2(vectors[1, 0], vectors[0, 0])))
    at = (float(centre[0]), float(centre[1]))
    return Ellipse(at, width, height, angle=angle, fill=False, edgecolor=_TARGET, lw=1.2)


def _draw_errors(axis: Axes, log: FlightLog, k: int) -> None:
    for estimate, truth, colour, name in (
        ("target_estimate_m", "target_m", _TARGET, "target"),
        ("robot_estimate_m", "robot_m", _ROBOT, "vehicle"),
    ):
        difference = log.array(estimate)[:, 0] - log.array(truth)[:, 0]
        error = np.linalg.norm(difference, axis=-1)
        axis.plot(error[: k + 1], color=colour, lw=1.2, label=name)
    axis.plot(log.array("sight_std_m")[: k + 1, 0], "--", color=_INK, lw=0.9, label="believed std")
    axis.set(xlim=(0, len(log.is_seen)), title="errors [m]")
    axis.legend(loc="upper right", fontsize=7)


def _draw_speeds(axis: Axes, log: FlightLog, k: int) -> None:
    aside = np.linalg.norm(log.array("aside_mps")[: k + 1, 0], axis=-1)
    axis.plot(log.array("follow_mps")[: k + 1, 0], color=_ROBOT, lw=1.2, label="following")
    axis.plot(aside, color=_TARGET, lw=1.2, label="observability")
    axis.set(xlim=(0, len(log.is_seen)), title="parts of the command [m/s]", xlabel="iteration")
    axis.legend(loc="lower right", fontsize=7)
