"""Pictures of a flight among points: the room from above, the errors and the command so far."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from experiments.bearing_only.config import FlightRun
from experiments.bearing_only.flying import Instant
from experiments.bearing_only.top_view import BELIEF, ROBOT, TARGET, Colour, TopView
from tracker.bearing_only.control import range_std
from tracker.bearing_only.measurements import TargetBelief

_HEIGHT_PX, _CHARTS_PX, _DPI = 540, 420, 100
_CHARTS_EVERY = 5
"""Iterations after which the charts are drawn anew: they are most of the work."""


class PointFilm:
    """Watches a flight and draws a picture of each iteration.

    Args:
        run: The flight's, for the title.
    """

    def __init__(self, run: FlightRun) -> None:
        self._view, self._iteration = TopView(), 0
        figure = Figure(figsize=(_CHARTS_PX / _DPI, _HEIGHT_PX / _DPI), dpi=_DPI)
        figure.suptitle(f"{run.study}  {run.controller}  seed {run.seed}", fontsize=9)
        self._canvas = FigureCanvasAgg(figure)
        upper = figure.add_axes((0.12, 0.55, 0.85, 0.35), title="errors [m]")
        lower = figure.add_axes((0.12, 0.1, 0.85, 0.35), title="command [m/s]")
        lower.set_xlabel("iteration")
        self._curves = {
            "target": _Curve(upper, "target", TARGET),
            "vehicle": _Curve(upper, "vehicle", ROBOT),
            "std": _Curve(upper, "believed range std", BELIEF, "--"),
            "follow": _Curve(lower, "following", ROBOT),
            "aside": _Curve(lower, "observability", TARGET),
        }
        for axis in (upper, lower):
            axis.set_xlim(0, run.iteration_count)
            axis.legend(
                loc="lower right",
                bbox_to_anchor=(1.01, 0.97),
                ncols=3,
                fontsize=7,
                handlelength=1.2,
                columnspacing=1.0,
            )

    def picture(self, instant: Instant) -> NDArray[np.uint8]:
        """(h, w, 3) uint8 RGB: the view from above and the charts, side by side."""
        above = self._view.draw(instant, _HEIGHT_PX)
        if instant.target is not None:
            for name, value in _values(instant, instant.target).items():
                self._curves[name].add(self._iteration, value)
        if self._iteration % _CHARTS_EVERY == 0:
            self._canvas.draw()
        self._iteration += 1
        charts = np.asarray(self._canvas.buffer_rgba())[..., :3]
        return np.asarray(np.hstack([above, charts]), np.uint8)


class _Curve:
    """A line that grows to the right; its axis grows with it."""

    def __init__(self, axis: Axes, label: str, colour: Colour, style: str = "-") -> None:
        red, green, blue = (part / 255.0 for part in colour)
        (self._line,) = axis.plot([], [], style, color=(red, green, blue), lw=1.2, label=label)
        self._axis, self._x, self._y = axis, list[int](), list[float]()

    def add(self, x: int, y: float) -> None:
        self._x.append(x)
        self._y.append(y)
        self._line.set_data(self._x, self._y)
        self._axis.relim()
        self._axis.autoscale_view(scalex=False)


def _values(instant: Instant, target: TargetBelief) -> dict[str, float]:
    """The height of each curve now."""
    pose = instant.pose
    return {
        "target": float(np.linalg.norm(target.position_m - instant.target_m)),
        "vehicle": float(np.linalg.norm(pose.position_m - instant.robot_m)),
        "std": float(range_std(pose, target)[1]),
        "follow": instant.follow_mps,
        "aside": instant.aside_mps,
    }
