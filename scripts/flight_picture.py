"""Makes docs/images/flight.jpg and flight-points.jpg: a flight as its film shows it.

    python scripts/flight_picture.py [ITERATION]

From images: what the camera sees (landmarks with the way they took, the window of CamShift), and
the flight from above. Among points: from above, and the errors so far.
"""

from __future__ import annotations

import sys
from pathlib import Path

import cv2
import numpy as np

from experiments.bearing_only.config import FlightRun
from experiments.bearing_only.film import film_of
from experiments.bearing_only.flying import Instant, fly
from experiments.report.style import figure_style
from experiments.study.processes import limit_threads

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "images"
STUDIES = {"flight.jpg": "circle-pixels", "flight-points.jpg": "circle"}


def main(iteration: int = 300) -> None:
    """Flies the circles with seed 0 up to the iteration and writes their pictures."""
    limit_threads()
    for name, study in STUDIES.items():
        out = FOLDER / name
        picture = last_picture(FlightRun(study, "turn", iteration_count=iteration + 1))
        cv2.imwrite(str(out), picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 88])
        print(out)


def last_picture(run: FlightRun) -> np.ndarray:
    """(h, w, 3) uint8 RGB of the end of the flight."""
    pictures = list[np.ndarray]()
    with figure_style():
        film = film_of(run)

        def watch(instant: Instant) -> None:
            pictures[:] = [film.picture(instant)]

        fly([run], watch)
    return pictures[0]


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:]))
