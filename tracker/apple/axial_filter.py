"""A filter on the sphere of axes: the Bingham distribution, whose exponent is quadratic.

An axis a and its opposite are the same state, p(a) ∝ exp(-½ aᵀΛa). An image that measured the axis
m with the information J (0 along m) multiplies it by exp(-½ aᵀJa), so the product of any number of
images is again of this form and Λ their sum: no linearisation, no start, no order. Method 1 of
[Zhou2011] says nothing about the tilt along the line of sight, and J says so.
"""

from collections.abc import Iterable

import numpy as np

from tracker.apple.single_view import AxisMeasurement, Method


class AxialFilter:
    """Fuses measurements of one axis that stands still."""

    def __init__(self, retained: float = 1.0) -> None:
        """Starts with no knowledge.

        Args:
            retained: Share of the information that is kept from one image to the next; 1 for a
                fruit that hangs still.
        """
        if not 0.0 < retained <= 1.0:
            raise ValueError(f"retained must be in (0, 1], got {retained!r}")
        self._retained = retained
        self._information = np.zeros((3, 3))
        self._direction = np.zeros(3)

    def update(self, measurement: AxisMeasurement) -> None:
        """Takes one image in. The calyx, where it is in sight, decides the sign of the axis."""
        self._information = self._retained * self._information + measurement.information
        vote = 1.0 if measurement.method is Method.OFFSET else 1e-3
        self._direction = self._direction + vote * measurement.axis

    @property
    def axis(self) -> np.ndarray:
        """(3,) the most probable axis, from calyx to stem; ValueError before the first image."""
        _, vectors = self._spectrum()
        axis = vectors[:, 0]
        return axis if axis @ self._direction >= 0.0 else -axis

    @property
    def covariance(self) -> np.ndarray:
        """(3, 3) [rad²] of small deviations of the axis, 0 along it.

        Source: the Gaussian that osculates the density at its mode: variance 1 / (λᵢ - λ₁) along
        the i-th eigenvector of Λ; at most that of a uniform axis, 1/3.
        """
        values, vectors = self._spectrum()
        variances = 1.0 / np.maximum(values[1:] - values[0], 3.0)
        return (vectors[:, 1:] * variances) @ vectors[:, 1:].T

    def _spectrum(self) -> tuple[np.ndarray, np.ndarray]:
        if not self._information.any():
            raise ValueError("no image has been taken in yet")
        return np.linalg.eigh(self._information)


def axial_mean(measurements: Iterable[AxisMeasurement]) -> AxialFilter:
    """The filter after all these measurements."""
    fused = AxialFilter()
    for measurement in measurements:
        fused.update(measurement)
    return fused
