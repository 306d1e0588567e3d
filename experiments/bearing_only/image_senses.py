"""Senses that take images of the hall and look at them."""

import numpy as np

from experiments.bearing_only.config import FlightRun
from experiments.bearing_only.pilots import rng_of
from sim.bearing_only.flight import Flight
from sim.bearing_only.hall import HallCamera, HallConfig
from tracker.bearing_only.image_sensor import ImageMeasurement, ImageSensor
from tracker.bearing_only.measurements import BodyIncrement, Measurements


class ImageSenses:
    """Rendered images: landmarks are corners, and the target is found by its colour."""

    def __init__(self, flight: Flight, run: FlightRun) -> None:
        self._flight = flight
        self.camera = HallCamera(HallConfig(), rng_of(run, "hall"), rng_of(run, "image"))
        self._sensor = ImageSensor(self.camera.reference_photograph())
        self.image = np.zeros((0, 0, 3), np.uint8)
        """The last one."""
        self.glimpse: ImageMeasurement | None = None
        """What was seen in it."""

    def measure(self, odometry: BodyIncrement) -> Measurements:
        """Takes an image and looks at it."""
        flight = self._flight
        self.image = self.camera.photograph(flight.position_m, flight.R_world_body, flight.target_m)
        self.glimpse = self._sensor.look(self.image)
        return Measurements(odometry, self.glimpse.features, self.glimpse.target_px)

    def close(self) -> None:
        """Frees the OpenGL context."""
        self.camera.close()
