"""Makes docs/images/flight.jpg: a flight among images, as its film shows it.

    python scripts/flight_picture.py [ITERATION] [FILE]

What the camera sees (landmarks with the way they took, the window of CamShift), and beside it the
flight from above.
"""

from __future__ import annotations

import sys
from pathlib import Path

import cv2
import numpy as np

from experiments.bearing_only.config import FlightRun
from experiments.bearing_only.flying import Instant, fly
from experiments.bearing_only.image_film import ImageFilm
from experiments.processes import limit_threads

OUT = Path(__file__).resolve().parents[1] / "docs" / "images" / "flight.jpg"


def main(iteration: int = 300, out: Path = OUT) -> None:
    """Flies the circle with seed 0 up to the iteration and writes its picture."""
    limit_threads()
    run = FlightRun("circle-pixels", "turn", iteration_count=iteration)
    film, pictures = ImageFilm(run), list[np.ndarray]()

    def watch(instant: Instant) -> None:
        pictures[:] = [film.picture(instant)]

    fly([run], watch)
    cv2.imwrite(str(out), pictures[0][..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 88])
    print(out)


if __name__ == "__main__":
    main(*(kind(word) for kind, word in zip((int, Path), sys.argv[1:], strict=False)))
