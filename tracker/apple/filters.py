"""Filters that fuse the attitudes of several images: as points in space, or as axes.

The state of the first two is P = 100 cm times the unit vector, a random walk (Eqs. 9, 10 of
[Zhou2011]); each image measures it directly. The three coordinates are filtered on their own and
never normalised. For such a model the Kalman filter is exact, and particles only approximate it.
"""

from dataclasses import dataclass

import numpy as np

from tracker.apple.single_view import AxisMeasurement, Method
from tracker.checks import require_count, require_positive

STATE_LENGTH_CM = 100.0
"""|P| of [Zhou2011] Eq. (9)."""


@dataclass(frozen=True)
class PointFilterConfig:
    """Noise of the random walk and of one image; the paper prints neither.

    Only their ratio shows in the published columns: the increments have the gains of a filter that
    starts without uncertainty and has q/σ near 0.35. Their size is taken so that the scatter of
    200 particles is like the published one.
    """

    measurement_sigma_cm: float = 5.0
    """σ of Eq. (12)."""
    walk_sigma_cm: float = 1.75
    """Deviation of each coordinate of E in Eq. (10)."""
    particle_count: int = 200
    """Number of particles of the particle filter; the published one."""

    def __post_init__(self) -> None:
        require_positive(self, "measurement_sigma_cm", "walk_sigma_cm")
        require_count(self, "particle_count")


def particle_estimates(
    measurements: np.ndarray, config: PointFilterConfig, rng: np.random.Generator
) -> np.ndarray:
    """(n, 3) weighted means after each of n measured attitudes, by the filter of [Zhou2011].

    All particles start at the first attitude with equal weights. Each step moves them by Gaussian
    noise (Eq. 10), multiplies the weights, of each coordinate apart, by the Gaussian of the
    distance to the measurement (Eqs. 6, 11, 12), normalises (Eq. 7) and takes the mean
    (Eqs. 8, 13). No resampling is described, and none is done. Eq. (5), whose text is garbled, is
    the prior as proposal.

    Args:
        measurements: (n, 3) unit vectors, or what stands for them, in the robot's frame.
        config: Noise and number of the particles.
        rng: Draws the random walk.

    Returns: estimates of the unit vector, P / 100 cm, not normalised; the first is the measurement.
    """
    _require_measurements(measurements)
    measured = STATE_LENGTH_CM * measurements
    particles = np.tile(measured[0], (config.particle_count, 1))
    log_weights = np.zeros_like(particles)
    estimates = [measured[0]]
    for measurement in measured[1:]:
        particles = particles + config.walk_sigma_cm * rng.standard_normal(particles.shape)
        distances = (particles - measurement) / config.measurement_sigma_cm
        log_weights -= 0.5 * distances**2
        weights = np.exp(log_weights - log_weights.max(axis=0))
        estimates.append((weights * particles).sum(axis=0) / weights.sum(axis=0))
    return np.array(estimates) / STATE_LENGTH_CM


def kalman_estimates(measurements: np.ndarray, config: PointFilterConfig) -> np.ndarray:
    """(n, 3) means after each of n measured attitudes, by the exact filter of the same model.

    What `particle_estimates` approaches with many particles: P₁ = y₁ without uncertainty, then
    p ← p + q², K = p / (p + σ²), P ← P + K (y - P), p ← (1 - K) p.
    """
    _require_measurements(measurements)
    estimates, variance = [measurements[0]], 0.0
    for measurement in measurements[1:]:
        variance += config.walk_sigma_cm**2
        gain = variance / (variance + config.measurement_sigma_cm**2)
        estimates.append(estimates[-1] + gain * (measurement - estimates[-1]))
        variance *= 1.0 - gain
    return np.array(estimates)


def _require_measurements(measurements: np.ndarray) -> None:
    if measurements.ndim != 2 or measurements.shape[1] != 3 or len(measurements) == 0:
        raise ValueError(f"measurements must have the shape (n, 3), got {measurements.shape}")
    if not np.isfinite(measurements).all():
        raise ValueError("measurements must be finite")


class AxialFilter:
    """Fuses measurements of one axis that stands still, on the sphere of axes.

    The state is the Bingham distribution, whose exponent is quadratic: an axis a and its opposite
    are the same, p(a) ∝ exp(-½ aᵀΛa). An image that measured the axis m with the information J (0
    along m) multiplies it by exp(-½ aᵀJa), so the product of any number of images is again of this
    form and Λ their sum: no linearisation, no start, no order. Method 1 of [Zhou2011] says nothing
    about the tilt along the line of sight, and J says so.
    """

    def __init__(self) -> None:
        """Starts with no knowledge."""
        self._information = np.zeros((3, 3))
        self._direction = np.zeros(3)

    def update(self, measurement: AxisMeasurement) -> None:
        """Takes one image in. The calyx, where it is in sight, decides the sign of the axis."""
        self._information = self._information + measurement.information
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
