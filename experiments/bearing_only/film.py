"""Films of flights: the view from above beside what the camera sees, or beside the errors."""

from collections import deque
from pathlib import Path

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from experiments.bearing_only.config import FlightRun
from experiments.bearing_only.flying import Instant, fly
from experiments.bearing_only.sensor_models import ImageSensorModel
from experiments.bearing_only.studies import world_of
from experiments.bearing_only.top_view import BELIEF, ROBOT, TARGET, Colour, TopView
from experiments.report.movie import INK, Movie, caption
from experiments.report.style import figure_style
from tracker.bearing_only.camshift import Sighting, SightingStatus
from tracker.bearing_only.control import range_std
from tracker.bearing_only.measurements import TargetBelief

_HEIGHT_PX, _CHARTS_PX, _DPI = 540, 420, 100
_CHARTS_EVERY = 5
"""Iterations after which the charts are drawn anew: they are most of the work."""
_TAIL = 10
"""Images back over which a landmark's way is drawn."""
_WINDOW: dict[SightingStatus, Colour] = {
    "tracked": (255, 225, 60),
    "found": (120, 255, 120),
    "cut": (255, 140, 30),
    "lost": (230, 50, 50),
}


def film(run: FlightRun, path: Path) -> None:
    """Flies the run once more and writes its film, an MP4."""
    with figure_style(), Movie(path, round(1.0 / world_of(run).dt_s)) as movie:
        making = film_of(run)
        flown = fly([run], lambda instant: movie.add(making.picture(instant)))
    if movie.is_empty:
        raise ValueError(f"there is nothing to film: {flown.error}")


def film_of(run: FlightRun) -> "PointFilm | ImageFilm":
    """What draws the flights of that kind; within `figure_style`."""
    return ImageFilm(run) if run.is_rendered else PointFilm(run)


class PointFilm:
    """Draws the room from above, the errors and the command so far.

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


class ImageFilm:
    """Draws what the camera sees, what is seen in it, and the room from above.

    Args:
        run: The flight's, for the title.
    """

    def __init__(self, run: FlightRun) -> None:
        self._run, self._view = run, TopView()
        self._tails: deque[dict[int, NDArray[np.float64]]] = deque(maxlen=_TAIL)
        self._iteration = 0

    def picture(self, instant: Instant) -> NDArray[np.uint8]:
        """(h, w, 3) uint8 RGB: the camera's view and the view from above, side by side."""
        sensors = instant.sensors
        assert isinstance(sensors, ImageSensorModel), "points make no images"
        assert sensors.seen is not None, "the watch comes after the measurement"
        image, seen, features = np.array(sensors.image), sensors.seen, sensors.seen.features
        self._tails.append(dict(zip(features.ids.tolist(), features.pixels, strict=True)))
        self._draw_landmarks(image)
        _draw_target(image, seen.sighting)
        seconds = self._iteration * instant.flight.config.dt_s
        caption(
            image,
            f"{self._run.controller}  seed {self._run.seed}  {seconds:5.2f} s   target "
            f"{seen.sighting.status}, {len(features.ids)} landmarks",
        )
        self._iteration += 1
        above = self._view.draw(instant, image.shape[0])
        return np.asarray(np.hstack([image, above]), np.uint8)

    def _draw_landmarks(self, image: NDArray[np.uint8]) -> None:
        """A ring on each, with a tail to where it was, in the colour of its name."""
        for name, pixel in self._tails[-1].items():
            colour = colour_of(name)
            way = [seen[name] for seen in self._tails if name in seen]
            points = np.rint(16.0 * (np.array(way) - 0.5)).astype(np.int32)
            cv2.polylines(image, [points], False, colour, 1, cv2.LINE_AA, 4)
            x, y = np.rint(16.0 * (pixel - 0.5)).astype(int).tolist()
            cv2.circle(image, (x, y), 16 * 4, colour, 1, cv2.LINE_AA, 4)


def colour_of(name: int) -> Colour:
    """A bright colour, far from that of the name before and never the target's."""
    hue = (40 + 37 * name) % 105  # yellow to blue, of OpenCV's 180
    rgb = cv2.cvtColor(np.array([[[20 + hue, 200, 255]]], np.uint8), cv2.COLOR_HSV2RGB)
    red, green, blue = rgb[0, 0].tolist()
    return red, green, blue


def _draw_target(image: NDArray[np.uint8], sighting: Sighting) -> None:
    """CamShift's window and the centroid that the pilot gets."""
    if sighting.window is None or sighting.centre_px is None:
        return
    colour = _WINDOW[sighting.status]
    left, top, width, height = sighting.window
    corner = left - 3, top - 3
    cv2.rectangle(image, corner, (left + width + 2, top + height + 2), colour, 2, cv2.LINE_AA)
    x, y = np.rint(16.0 * (sighting.centre_px - 0.5)).astype(int).tolist()
    cv2.line(image, (x - 96, y), (x + 96, y), INK, 1, cv2.LINE_AA, 4)
    cv2.line(image, (x, y - 96), (x, y + 96), INK, 1, cv2.LINE_AA, 4)
