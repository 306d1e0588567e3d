"""Extended Kalman filters of a target by its pixel alone, with the vehicle's own doubt in them.

A target moves on a straight line, or in a turn about the vertical. States are (..., 3) position,
(..., 3) velocity and, for the turn, the turn rate about the world's z axis. Every function
broadcasts over leading axes.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tracker.bearing_only.measurements import PinholeCamera, PoseBelief, TargetBelief
from tracker.bearing_only.observation import TargetView, view_target
from tracker.bearing_only.small_matrices import inverse_and_determinant, product, sandwich
from tracker.checks import require_positive


@dataclass(frozen=True)
class TargetNoise:
    """What a target filter takes for granted about noise."""

    acceleration_std_mps2: float = 1.0
    """White acceleration of the straight model, per axis; a circle of 8 m at 2 m/s has 0.5."""
    pixel_std_px: float = 3.0
    """[Wu2022] Table 1."""
    turn_acceleration_std_mps2: float = 0.1
    """White acceleration of the turn model, per axis: its turn rate explains the rest."""
    turn_rate_std_radps: float = 0.5
    """Deviation of the turn rate before anything is known of it."""
    turn_rate_drift_radps2: float = 0.02
    """How fast the turn rate changes [rad/s per square root of a second]."""

    def __post_init__(self) -> None:
        require_positive(
            self,
            "acceleration_std_mps2",
            "pixel_std_px",
            "turn_acceleration_std_mps2",
            "turn_rate_std_radps",
            "turn_rate_drift_radps2",
        )


@dataclass(frozen=True, eq=False)
class Correction:
    """One Kalman update: how the state changes, and how likely the pixel was."""

    state: NDArray[np.float64]
    covariance: NDArray[np.float64]
    innovation_covariance: NDArray[np.float64]
    log_likelihood: NDArray[np.float64]


def correct(
    state: NDArray[np.float64],
    covariance: NDArray[np.float64],
    view: TargetView,
    pixel: NDArray[np.float64],
    R: NDArray[np.float64],
) -> Correction:
    """The update of (..., n) states whose first three entries are the position.

    Source: [Wu2022] Eqs. 8 to 10, with two corrections. Eq. 10 is K = P H^T S^-1: the text has
    neither the transpose nor the inverse. Eq. 9, P - K S K^T, is computed in Joseph's form, which
    stays positive when rounding does not.

    Args:
        state: (..., n).
        covariance: (..., n, n).
        view: Where the target should appear from there.
        pixel: (..., 2).
        R: (..., 2, 2): noise of the pixel and what the doubt about the pose adds.
    """
    n, leading = state.shape[-1], state.shape[:-1]
    moved, P, S, log_likelihood = _corrections(
        state.reshape(-1, n),
        covariance.reshape(-1, n, n),
        view.by_target.reshape(-1, 2, 3),
        (pixel - view.pixel).reshape(-1, 2),
        R.reshape(-1, 2, 2),
    )
    return Correction(
        moved.reshape(state.shape),
        P.reshape(covariance.shape),
        S.reshape(*leading, 2, 2),
        log_likelihood.reshape(leading),
    )


@njit(cache=True, error_model="numpy")
def _corrections(
    states: np.ndarray,
    covariances: np.ndarray,
    by_target: np.ndarray,
    residuals: np.ndarray,
    noises: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """`correct` for (m, n) states, (m, 2, 3) derivatives and (m, 2) residuals."""
    m, n = states.shape
    moved, corrected = np.empty_like(states), np.empty_like(covariances)
    innovations, log_likelihood = np.empty((m, 2, 2)), np.empty(m)
    H, eye = np.zeros((2, n)), np.eye(n)
    for i in range(m):
        H[:, :3] = by_target[i]
        P, R, residual = covariances[i], noises[i], residuals[i]
        PHT = product(P, H.T)
        S = product(H, PHT) + R
        inverse, determinant = inverse_and_determinant(S)
        K = product(PHT, inverse)
        new = sandwich(eye - product(K, H), P) + sandwich(K, R)
        distance = 0.0
        for j in range(2):
            for k in range(2):
                distance += residual[j] * inverse[j, k] * residual[k]
        moved[i] = states[i] + K[:, 0] * residual[0] + K[:, 1] * residual[1]
        corrected[i] = 0.5 * (new + new.T)
        innovations[i] = S
        log_likelihood[i] = -0.5 * (distance + np.log(determinant)) - np.log(2.0 * np.pi)
    return moved, corrected, innovations, log_likelihood


def inverse_2x2(S: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., 2, 2) inverses; much faster than the general way for many small ones."""
    adjugate = np.empty_like(S)
    adjugate[..., 0, 0], adjugate[..., 1, 1] = S[..., 1, 1], S[..., 0, 0]
    adjugate[..., 0, 1], adjugate[..., 1, 0] = -S[..., 0, 1], -S[..., 1, 0]
    return adjugate / determinant_2x2(S)[..., None, None]


def determinant_2x2(S: NDArray[np.float64]) -> NDArray[np.float64]:
    """(...,) determinants of (..., 2, 2) matrices."""
    return S[..., 0, 0] * S[..., 1, 1] - S[..., 0, 1] * S[..., 1, 0]


def measurement_noise(
    view: TargetView, pose: PoseBelief, pixel_std_px: float
) -> NDArray[np.float64]:
    """(..., 2, 2): H_r P_r H_r^T + R of [Wu2022] Eq. 7."""
    by_pose = view.by_pose @ pose.covariance @ np.swapaxes(view.by_pose, -1, -2)
    return by_pose + pixel_std_px**2 * np.eye(2)


class _Ekf:
    """A state, its covariance and the update that every motion model shares."""

    def __init__(
        self,
        camera: PinholeCamera,
        noise: TargetNoise,
        state: NDArray[np.float64],
        covariance: NDArray[np.float64],
    ) -> None:
        self._camera, self._noise = camera, noise
        self._state, self._P = state, covariance

    @property
    def belief(self) -> TargetBelief:
        """Position and velocity now."""
        return TargetBelief(self._state[..., :3], self._state[..., 3:6], self._P[..., :6, :6])

    def update(
        self, pixel: NDArray[np.float64], pose: PoseBelief, is_seen: NDArray[np.bool_]
    ) -> NDArray[np.float64]:
        """[Wu2022] Eqs. 6 to 10 for those seen and in front."""
        view = view_target(self._camera, pose, self._state[..., :3])
        R = measurement_noise(view, pose, self._noise.pixel_std_px)
        new = correct(self._state, self._P, view, pixel, R)
        is_used = is_seen & view.is_in_front
        self._state = np.where(is_used[..., None], new.state, self._state)
        self._P = np.where(is_used[..., None, None], new.covariance, self._P)
        return new.innovation_covariance


class StraightFilter(_Ekf):
    """The filter of [Wu2022] section 4: constant velocity."""

    def __init__(
        self, camera: PinholeCamera, noise: TargetNoise, prior: TargetBelief, dt_s: float
    ) -> None:
        state = np.concatenate([prior.position_m, prior.velocity_mps], axis=-1)
        super().__init__(camera, noise, state, prior.covariance.copy())
        self._F = straight_transition(dt_s)
        self._Q = acceleration_noise(dt_s, noise.acceleration_std_mps2)

    def predict(self) -> None:
        """[Wu2022] Eqs. 4 and 5; the text of Eq. 5 has the state X where the covariance P is."""
        self._state = self._state @ self._F.T
        self._P = self._F @ self._P @ self._F.T + self._Q


class TurnFilter(_Ekf):
    """A coordinated turn whose rate is estimated; a straight line is a turn of rate zero."""

    def __init__(
        self, camera: PinholeCamera, noise: TargetNoise, prior: TargetBelief, dt_s: float
    ) -> None:
        super().__init__(camera, noise, *with_turn_rate(prior, noise))
        self._dt_s, self._Q = dt_s, turn_noise(noise, dt_s)

    def predict(self) -> None:
        """Turns the state; the covariance follows by the Jacobian."""
        self._state, F = turn(self._state, self._dt_s)
        self._P = F @ self._P @ np.swapaxes(F, -1, -2) + self._Q


def turn_noise(noise: TargetNoise, dt_s: float) -> NDArray[np.float64]:
    """(7, 7) process noise of the turn model."""
    Q = np.zeros((7, 7))
    Q[:6, :6] = acceleration_noise(dt_s, noise.turn_acceleration_std_mps2)
    Q[6, 6] = noise.turn_rate_drift_radps2**2 * dt_s
    return Q


def with_turn_rate(
    prior: TargetBelief, noise: TargetNoise
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(..., 7) state and (..., 7, 7) covariance of a target whose turn rate is unknown."""
    leading = prior.position_m.shape[:-1]
    state = np.zeros((*leading, 7))
    state[..., :3], state[..., 3:6] = prior.position_m, prior.velocity_mps
    P = np.zeros((*leading, 7, 7))
    P[..., :6, :6] = prior.covariance
    P[..., 6, 6] = noise.turn_rate_std_radps**2
    return state, P


def straight_transition(dt_s: float) -> NDArray[np.float64]:
    """(6, 6) transition of constant velocity; A of [Wu2022] Eqs. 1 and 4."""
    F = np.eye(6)
    F[:3, 3:] = dt_s * np.eye(3)
    return F


def acceleration_noise(dt_s: float, acceleration_std_mps2: float) -> NDArray[np.float64]:
    """(6, 6) covariance of an acceleration that is constant in a step and drawn anew for each.

    Q of [Wu2022] Eq. 5, which the text does not give.
    """
    eye, variance = np.eye(3), acceleration_std_mps2**2
    return variance * np.block(
        [[dt_s**4 / 4 * eye, dt_s**3 / 2 * eye], [dt_s**3 / 2 * eye, dt_s**2 * eye]]
    )


def turn(
    state: NDArray[np.float64], dt_s: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(..., 7) states after a coordinated turn, and their (..., 7, 7) Jacobians.

    The horizontal velocity turns with a constant rate, the vertical one stays.
    Source: [BarShalom2001] section 11.7, with the sines and cosines expanded near a rate of zero.
    """
    vx, vy, vz, rate = np.moveaxis(state[..., 3:], -1, 0)
    a, b, da, db = _turn_integrals(rate, dt_s)
    sine, cosine = np.sin(rate * dt_s), np.cos(rate * dt_s)
    moved = state.copy()
    moved[..., 0] += a * vx - b * vy
    moved[..., 1] += b * vx + a * vy
    moved[..., 2] += dt_s * vz
    moved[..., 3] = cosine * vx - sine * vy
    moved[..., 4] = sine * vx + cosine * vy
    F = np.zeros((*state.shape, 7))
    F[..., range(7), range(7)] = 1.0
    F[..., 0, 3], F[..., 0, 4], F[..., 0, 6] = a, -b, da * vx - db * vy
    F[..., 1, 3], F[..., 1, 4], F[..., 1, 6] = b, a, db * vx + da * vy
    F[..., 2, 5] = dt_s
    F[..., 3, 3], F[..., 3, 4], F[..., 3, 6] = cosine, -sine, -dt_s * moved[..., 4]
    F[..., 4, 3], F[..., 4, 4], F[..., 4, 6] = sine, cosine, dt_s * moved[..., 3]
    return moved, F


def _turn_integrals(rate: NDArray[np.float64], dt_s: float) -> tuple[NDArray[np.float64], ...]:
    """sin(w t)/w and (1 - cos(w t))/w, and their derivatives by w."""
    angle = rate * dt_s
    is_small = np.abs(angle) < 1e-3
    w = np.where(is_small, 1.0, rate)
    sine, cosine = np.sin(angle), np.cos(angle)
    a = np.where(is_small, dt_s * (1.0 - angle**2 / 6.0), sine / w)
    b = np.where(is_small, dt_s * angle * (0.5 - angle**2 / 24.0), (1.0 - cosine) / w)
    da = np.where(is_small, -(dt_s**2) * angle / 3.0, (dt_s * cosine - a) / w)
    db = np.where(is_small, dt_s**2 * (0.5 - angle**2 / 8.0), (dt_s * sine - b) / w)
    return a, b, da, db
