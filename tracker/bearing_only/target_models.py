"""How a target moves: on a straight line, or in a turn about the vertical; what neither explains.

States are (..., 3) position, (..., 3) velocity and, for the turn, the turn rate about the world's z
axis. Every function broadcasts over leading axes.
"""

import numpy as np
from numpy.typing import NDArray


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
