"""What a vehicle senses: pixels of points with noise, or images, which have to be understood.

The world is read here, and nothing of it but measurements goes on to the pilot.
"""

from typing import Protocol

from experiments.bearing_only.config import FlightRun
from sim.bearing_only.flight import Flight
from tracker.bearing_only.measurements import BodyIncrement, FeatureObservation, Measurements


class Senses(Protocol):
    """Measures; close it when done."""

    def measure(self, odometry: BodyIncrement) -> Measurements:
        """What the sensors give now: the only thing of the world that the pilot gets."""
        ...

    def close(self) -> None:
        """Frees what it holds."""
        ...


class PointSenses:
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


def senses_of(run: FlightRun, flight: Flight) -> Senses:
    """The senses of a run; only those with images import MuJoCo."""
    if run.is_rendered:
        from experiments.bearing_only.image_senses import ImageSenses

        return ImageSenses(flight, run)
    return PointSenses(flight)
