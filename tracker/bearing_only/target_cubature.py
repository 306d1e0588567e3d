"""Constant velocity again, but with cubature points and a square root of the covariance."""

import numpy as np
from numpy.typing import NDArray

from tracker.bearing_only.measurements import PinholeCamera, PoseBelief, TargetBelief
from tracker.bearing_only.observation import view_target
from tracker.bearing_only.target_filter import (
    TargetNoise,
    acceleration_noise,
    inverse_2x2,
    measurement_noise,
    straight_transition,
)


class CubatureFilter:
    """A square-root cubature Kalman filter.

    The pixel is averaged over 12 points instead of linearised at the mean, and the factor L of
    P = L L^T is carried, so that the covariance cannot become indefinite. The doubt about the pose
    enters by its Jacobian, as in [Wu2022] Eq. 7.
    Source: [Arasaratnam2009] section VII (the square-root cubature Kalman filter).
    """

    def __init__(
        self, camera: PinholeCamera, noise: TargetNoise, prior: TargetBelief, dt_s: float
    ) -> None:
        self._camera, self._noise = camera, noise
        self._F = straight_transition(dt_s)
        # Of rank three: one column for each axis that accelerates.
        sigma, eye = noise.acceleration_std_mps2, np.eye(3)
        self._Q_root = sigma * np.concatenate([dt_s**2 / 2 * eye, dt_s * eye])
        assert np.allclose(self._Q_root @ self._Q_root.T, acceleration_noise(dt_s, sigma))
        self._state = np.concatenate([prior.position_m, prior.velocity_mps], axis=-1)
        self._L = np.asarray(np.linalg.cholesky(prior.covariance), np.float64)

    @property
    def belief(self) -> TargetBelief:
        """Position and velocity now."""
        P = self._L @ np.swapaxes(self._L, -1, -2)
        return TargetBelief(self._state[..., :3], self._state[..., 3:], P)

    def predict(self) -> None:
        """Linear, hence exact: the factor of the sum by a triangularisation."""
        self._state = self._state @ self._F.T
        moved = self._F @ self._L
        Q_root = np.broadcast_to(self._Q_root, (*moved.shape[:-1], 3))
        self._L = _factor(np.concatenate([moved, Q_root], axis=-1))

    def update(
        self, pixel: NDArray[np.float64], pose: PoseBelief, is_seen: NDArray[np.bool_]
    ) -> NDArray[np.float64]:
        """Moments of the pixel over the points; the factor by one triangularisation."""
        mean = self._state
        spread = np.sqrt(6.0) * np.concatenate([self._L, -self._L], axis=-1)
        points = np.moveaxis(mean[..., None] + spread, -1, 0)
        views = view_target(self._camera, pose, points[..., :3])
        is_used = is_seen & views.is_in_front.all(axis=0)
        pixels = np.moveaxis(views.pixel, 0, -1)
        predicted = pixels.mean(axis=-1)
        X = spread / np.sqrt(12.0)
        Z = (pixels - predicted[..., None]) / np.sqrt(12.0)
        at_mean = view_target(self._camera, pose, mean[..., :3])
        R_root = np.linalg.cholesky(measurement_noise(at_mean, pose, self._noise.pixel_std_px))
        S = Z @ np.swapaxes(Z, -1, -2) + R_root @ np.swapaxes(R_root, -1, -2)
        K = X @ np.swapaxes(Z, -1, -2) @ inverse_2x2(S)
        L = _factor(np.concatenate([X - K @ Z, K @ R_root], axis=-1))
        moved = mean + np.einsum("...ij,...j->...i", K, pixel - predicted)
        self._state = np.where(is_used[..., None], moved, mean)
        self._L = np.where(is_used[..., None, None], L, self._L)
        return S


def _factor(A: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., n, n) lower triangular L with L L^T = A A^T of (..., n, m) matrices."""
    return np.swapaxes(np.linalg.qr(np.swapaxes(A, -1, -2), mode="r"), -1, -2)
