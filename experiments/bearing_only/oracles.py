"""The true pose, or the true pose with an error of known size: a control arm, not a method."""

import numpy as np
from numpy.typing import NDArray

from experiments.bearing_only.config import PoseErrorKind
from sim.bearing_only.flight import Flight
from tracker.bearing_only.measurements import Measurements, PoseBelief


class KnownPose:
    """A pose source that reads the truth, and adds the error that it was asked for."""

    def __init__(
        self, flight: Flight, kind: PoseErrorKind, std_m: float, draws: NDArray[np.float64]
    ) -> None:
        """Sets up the source.

        Args:
            flight: Whose truth it reads.
            kind: What error it adds.
            std_m: Size of the error; of a drift at the last iteration.
            draws: (..., k, 3) standard normal.
        """
        self._flight, self._kind = flight, kind
        if kind == "drift":
            draws = np.cumsum(draws, axis=-2) / np.sqrt(draws.shape[-2])
        self._error = std_m * draws
        self._std_m = std_m

    def update(self, measurements: Measurements) -> PoseBelief:
        """The pose at the flight's iteration."""
        k, position = self._flight.iteration, self._flight.position_m
        covariance = np.zeros((*position.shape[:-1], 6, 6))
        if self._kind == "none":
            return PoseBelief(position, self._flight.R_world_body, covariance)
        share = (k + 1) / self._error.shape[-2] if self._kind == "drift" else 1.0
        if self._kind != "hidden":
            covariance[..., range(3), range(3)] = share * self._std_m**2
        return PoseBelief(position + self._error[..., k, :], self._flight.R_world_body, covariance)
