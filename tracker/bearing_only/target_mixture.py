"""Straight or turning: an interacting multiple-model filter that weighs both at every step."""

import numpy as np
from numpy.typing import NDArray

from tracker.bearing_only.measurements import PinholeCamera, PoseBelief, TargetBelief
from tracker.bearing_only.observation import view_target
from tracker.bearing_only.target_filter import (
    TargetNoise,
    acceleration_noise,
    correct,
    measurement_noise,
    straight_transition,
    turn,
    turn_noise,
    with_turn_rate,
)

STAY_PROBABILITY = 0.98
"""Probability that a target goes on in a step as it did in the last."""


class MixtureFilter:
    """Two extended Kalman filters that mix their states before each prediction.

    The first axis of state, covariance and weight is the model: straight, turn. The straight model
    forgets the turn rate at every step, so that both have a state of seven and can be mixed.
    Source: [BarShalom2001] section 11.6.6 (the IMM estimator).
    """

    def __init__(
        self, camera: PinholeCamera, noise: TargetNoise, prior: TargetBelief, dt_s: float
    ) -> None:
        self._camera, self._noise, self._dt_s = camera, noise, dt_s
        state, P = with_turn_rate(prior, noise)
        self._state, self._P = np.stack([state, state]), np.stack([P, P])
        self._weight = np.full((2, *state.shape[:-1]), 0.5)
        self._switch = np.full((2, 2), 1.0 - STAY_PROBABILITY)
        np.fill_diagonal(self._switch, STAY_PROBABILITY)
        self._F_straight = np.zeros((7, 7))
        self._F_straight[:6, :6] = straight_transition(dt_s)
        Q_straight = np.zeros((7, 7))
        Q_straight[:6, :6] = acceleration_noise(dt_s, noise.acceleration_std_mps2)
        Q_straight[6, 6] = noise.turn_rate_std_radps**2
        self._Q_straight, self._Q_turn = Q_straight, turn_noise(noise, dt_s)

    @property
    def weight(self) -> NDArray[np.float64]:
        """(2, ...): how far each model is believed."""
        return self._weight

    @property
    def belief(self) -> TargetBelief:
        """Mean and covariance of the mixture."""
        mean, P = _moments(self._weight, self._state, self._P)
        return TargetBelief(mean[..., :3], mean[..., 3:6], P[..., :6, :6])

    def predict(self) -> None:
        """Mixes the models, then moves each on by its own motion."""
        joint = np.einsum("ij,i...->ij...", self._switch, self._weight)
        self._weight = joint.sum(axis=0)
        share = joint / self._weight
        mixed = [_moments(share[:, j], self._state, self._P) for j in range(2)]
        (straight, P_straight), (turning, P_turning) = mixed
        F = self._F_straight
        straight, P_straight = straight @ F.T, F @ P_straight @ F.T + self._Q_straight
        turning, F = turn(turning, self._dt_s)
        P_turning = F @ P_turning @ np.swapaxes(F, -1, -2) + self._Q_turn
        self._state, self._P = np.stack([straight, turning]), np.stack([P_straight, P_turning])

    def update(
        self, pixel: NDArray[np.float64], pose: PoseBelief, is_seen: NDArray[np.bool_]
    ) -> NDArray[np.float64]:
        """Updates each model, and their weights by how well they foresaw the pixel."""
        view = view_target(self._camera, pose, self._state[..., :3])
        R = measurement_noise(view, pose, self._noise.pixel_std_px)
        new = correct(self._state, self._P, view, pixel, R)
        is_used = is_seen & view.is_in_front.all(axis=0)
        log = np.log(self._weight) + new.log_likelihood
        weight = np.exp(log - log.max(axis=0))
        weight = np.maximum(weight / weight.sum(axis=0), 1e-9)
        S = np.einsum("i...,i...jk->...jk", self._weight, new.innovation_covariance)
        self._weight = np.where(is_used, weight / weight.sum(axis=0), self._weight)
        self._state = np.where(is_used[..., None], new.state, self._state)
        self._P = np.where(is_used[..., None, None], new.covariance, self._P)
        return S


def _moments(
    weight: NDArray[np.float64], state: NDArray[np.float64], P: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean and covariance of a mixture along the first axis."""
    w = weight[..., None]
    mean = (w * state).sum(axis=0)
    d = state - mean
    spread = P + d[..., :, None] * d[..., None, :]
    return mean, (w[..., None] * spread).sum(axis=0)
