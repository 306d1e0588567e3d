"""What a vehicle measures: pixels of points with noise, or images, which have to be understood.

The world is read here, and nothing of it but measurements goes on to the pilot.
"""

from typing import Protocol

import numpy as np

from experiments.bearing_only.config import FlightRun
from experiments.bearing_only.pilots import rng_of
from sim.bearing_only.flight import Flight
from tracker.bearing_only.image_sensor import ImageMeasurement, ImageSensor
from tracker.bearing_only.measurements import BodyIncrement, FeatureObservation, Measurements


class SensorModel(Protocol):
    """Measures; close it when done."""

    def measure(self, odometry: BodyIncrement) -> Measurements:
        """What the sensors give now: the only thing of the world that the pilot gets."""
        ...

    def close(self) -> None:
        """Frees what it holds."""
        ...


class PointSensorModel:
    """Pixels of points, with noise, as [Wu2022] section 6.1.1."""

    def __init__(self, flight: Flight) -> None:
        self._flight = flight

    def measure(self, odometry: BodyIncrement) -> Measurements:
        """Landmarks in view, of a single flight, and the target."""
        sight = self._flight.look()
        if self._flight.position_m.ndim > 1:
            none = FeatureObservation.none()
            return Measurements(odometry, none, sight.target_px, sight.is_target_seen)
        features = FeatureObservation(sight.landmark_ids, sight.landmark_px)
        return Measurements(odometry, features, sight.target_px if sight.is_target_seen else None)

    def close(self) -> None:
        """Holds nothing."""


class ImageSensorModel:
    """Rendered images: landmarks are corners, and the target is found by its colour."""

    def __init__(self, flight: Flight, run: FlightRun) -> None:
        from sim.bearing_only.hall import HallCamera, HallConfig

        self._flight = flight
        self.camera = HallCamera(HallConfig(), rng_of(run, "hall"), rng_of(run, "image"))
        self._sensor = ImageSensor(self.camera.reference_photograph())
        self.image = np.zeros((0, 0, 3), np.uint8)
        """The last one."""
        self.seen: ImageMeasurement | None = None
        """What was seen in it."""

    def measure(self, odometry: BodyIncrement) -> Measurements:
        """Takes an image and looks at it."""
        flight = self._flight
        self.image = self.camera.photograph(flight.position_m, flight.R_world_body, flight.target_m)
        self.seen = self._sensor.look(self.image)
        return Measurements(odometry, self.seen.features, self.seen.target_px)

    def close(self) -> None:
        """Frees the OpenGL context."""
        self.camera.close()


def sensor_model_of(run: FlightRun, flight: Flight) -> SensorModel:
    """The sensors of a run; only those with images import MuJoCo."""
    return ImageSensorModel(flight, run) if run.is_rendered else PointSensorModel(flight)
