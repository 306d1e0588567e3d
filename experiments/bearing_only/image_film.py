"""Pictures of a flight from images: what the camera sees, what is seen in it, and from above."""

from collections import deque

import cv2
import numpy as np
from numpy.typing import NDArray

from experiments.bearing_only.config import FlightRun
from experiments.bearing_only.flying import Instant
from experiments.bearing_only.image_senses import ImageSenses
from experiments.bearing_only.top_view import Colour, TopView
from experiments.report.movie import INK, caption
from tracker.bearing_only.camshift import SightingStatus
from tracker.bearing_only.image_sensor import ImageMeasurement

_TAIL = 10
"""Images back over which a landmark's way is drawn."""
_WINDOW: dict[SightingStatus, Colour] = {
    "tracked": (255, 225, 60),
    "found": (120, 255, 120),
    "cut": (255, 140, 30),
    "lost": (230, 50, 50),
}


class ImageFilm:
    """Watches a flight and draws a picture of each iteration.

    Args:
        run: The flight's, for the title.
    """

    def __init__(self, run: FlightRun) -> None:
        self._run, self._view = run, TopView()
        self._tails: deque[dict[int, NDArray[np.float64]]] = deque(maxlen=_TAIL)
        self._iteration = 0

    def picture(self, instant: Instant) -> NDArray[np.uint8]:
        """(h, w, 3) uint8 RGB: the camera's view and the view from above, side by side."""
        senses = instant.senses
        assert isinstance(senses, ImageSenses), "points make no images"
        assert senses.glimpse is not None, "the watch comes after the measurement"
        image = np.array(senses.image)
        self._tails.append(
            dict(
                zip(
                    senses.glimpse.features.ids.tolist(),
                    senses.glimpse.features.pixels,
                    strict=True,
                )
            )
        )
        self._draw_landmarks(image)
        _draw_target(image, senses.glimpse)
        seconds = self._iteration * instant.flight.config.dt_s
        features = len(senses.glimpse.features.ids)
        caption(
            image,
            f"{self._run.controller}  seed {self._run.seed}  {seconds:5.2f} s   target "
            f"{senses.glimpse.sighting.status}, {features} landmarks",
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


def _draw_target(image: NDArray[np.uint8], glimpse: ImageMeasurement) -> None:
    """CamShift's window and the centroid that the pilot gets."""
    sighting = glimpse.sighting
    if sighting.window is None or sighting.centre_px is None:
        return
    colour = _WINDOW[sighting.status]
    left, top, width, height = sighting.window
    corner = left - 3, top - 3
    cv2.rectangle(image, corner, (left + width + 2, top + height + 2), colour, 2, cv2.LINE_AA)
    x, y = np.rint(16.0 * (sighting.centre_px - 0.5)).astype(int).tolist()
    cv2.line(image, (x - 96, y), (x + 96, y), INK, 1, cv2.LINE_AA, 4)
    cv2.line(image, (x, y - 96), (x, y + 96), INK, 1, cv2.LINE_AA, 4)
