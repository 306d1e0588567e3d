"""Films of flights: the view from above beside what the camera sees, or beside the errors."""

from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from experiments.bearing_only.config import FlightRun
from experiments.bearing_only.flying import Instant, fly
from experiments.bearing_only.image_film import ImageFilm
from experiments.bearing_only.point_film import PointFilm
from experiments.bearing_only.studies import world_of
from experiments.report.movie import Movie
from experiments.report.style import figure_style


class Film(Protocol):
    """Draws the instants of a flight."""

    def picture(self, instant: Instant) -> NDArray[np.uint8]:
        """(h, w, 3) uint8 RGB."""
        ...


def film_of(run: FlightRun) -> Film:
    """What draws the flights of that kind; within `figure_style`."""
    return ImageFilm(run) if run.is_rendered else PointFilm(run)


def film(run: FlightRun, path: Path) -> None:
    """Flies the run once more and writes its film, an MP4."""
    with figure_style(), Movie(path, round(1.0 / world_of(run).dt_s)) as movie:
        making = film_of(run)
        flown = fly([run], lambda instant: movie.add(making.picture(instant)))
    if movie.is_empty:
        raise ValueError(f"there is nothing to film: {flown.error}")
