"""The particle filter against the exact answer of a linear-Gaussian problem.

In the translation subgroup the state equation X_k = X_{k-1} exp(a log(X_{k-2}^-1 X_{k-1}) + dW) is
linear, and a direct observation of the translation makes the Kalman filter on (x_k, x_{k-1}) exact.
"""

import numpy as np
import pytest

from tracker.affine.filter import FilterConfig, ParticleFilter

A = 0.9
PROCESS_STD = 0.05
OBSERVATION_STD = 0.04
TINY = 1e-5


class TranslationObservation:
    """y = t + noise; the information form is exact everywhere."""

    def __init__(self, y):
        self.y = y

    def log_likelihood(self, warps):
        return -0.5 * ((warps[:, :2, 2] - self.y) ** 2).sum(axis=1) / OBSERVATION_STD**2

    def linearise(self, warps, iteration=0):
        gradient = np.zeros((len(warps), 6))
        gradient[:, 4:] = (self.y - warps[:, :2, 2]) / OBSERVATION_STD**2
        information = np.zeros((len(warps), 6, 6))
        information[:, [4, 5], [4, 5]] = 1.0 / OBSERVATION_STD**2
        return gradient, information


def kalman(observations, start, previous):
    """Exact means (k, 2) and variances (k,) of the position."""
    F = np.array([[1 + A, -A], [1.0, 0.0]])
    Q = np.diag([PROCESS_STD**2, 0.0])
    H = np.array([[1.0, 0.0]])
    m, P = np.stack([start, previous]), np.zeros((2, 2))
    means, variances = [], []
    for y in observations:
        m, P = F @ m, F @ P @ F.T + Q
        S = H @ P @ H.T + OBSERVATION_STD**2
        gain = P @ H.T / S
        m, P = m + gain * (y - m[:1]), P - gain @ H @ P
        means.append(m[0])
        variances.append(P[0, 0])
    return np.array(means), np.array(variances)


def simulate(rng, count=25):
    x = [np.zeros(2), np.array([0.1, -0.05])]
    for _ in range(count):
        x.append(x[-1] + A * (x[-1] - x[-2]) + PROCESS_STD * rng.standard_normal(2))
    truth = np.array(x[2:])
    return x[1], x[0], truth + OBSERVATION_STD * rng.standard_normal(truth.shape)


def settings(**changes):
    base = dict(
        particle_count=3000,
        autoregression=A,
        noise_per_root_s=(TINY, TINY, TINY, TINY, PROCESS_STD, PROCESS_STD),
        resampling="systematic",
        resampling_threshold=0.5,
        prior_share=0.0,
        iterations=1,
    )
    return FilterConfig(**(base | changes))


@pytest.mark.parametrize(
    "config",
    [
        settings(),
        settings(resampling="residual"),
        settings(resampling="multinomial", resampling_threshold=1.0),
        settings(prior_share=0.2),
        settings(iterations=3),
        settings(family_size=3),
        settings(state_space="vector", proposal="prior"),
        settings(proposal="prior"),
    ],
    ids=[
        "gaussian",
        "residual",
        "multinomial",
        "mixture",
        "iterated",
        "families",
        "vector-prior",
        "prior",
    ],
)
def test_filter_equals_the_kalman_filter(config):
    start, previous, observations = simulate(np.random.default_rng(0))
    means, variances = kalman(observations, start, previous)
    bootstrap = ParticleFilter(config, np.random.default_rng(1))
    bootstrap.start(translation(start), translation(previous))
    errors, spreads = [], []
    for y in observations:
        estimate = bootstrap.step(TranslationObservation(y), 1.0)
        errors.append(estimate.warp[:2, 2])
        spreads.append(np.trace(estimate.covariance[4:, 4:]) / 2)
    standard = np.sqrt(variances)[:, None]
    assert (np.abs(np.array(errors) - means) / standard).mean() < 0.06
    assert np.mean(spreads) == pytest.approx(variances.mean(), rel=0.1)


def test_optimal_proposal_gives_a_larger_ess_than_the_prior():
    start, previous, observations = simulate(np.random.default_rng(2))
    ess = {}
    for proposal in ("gaussian", "prior"):
        config = settings(proposal=proposal, particle_count=500)
        particle_filter = ParticleFilter(config, np.random.default_rng(3))
        particle_filter.start(translation(start), translation(previous))
        ess[proposal] = np.mean(
            [particle_filter.step(TranslationObservation(y), 1.0).ess for y in observations]
        )
    assert ess["gaussian"] > 1.2 * ess["prior"]


def test_a_step_twice_as_long_moves_twice_as_far():
    particle_filter = ParticleFilter(settings(particle_count=10), np.random.default_rng(0))
    particle_filter.start(translation([0.2, 0.0]), translation([0.0, 0.0]), step_s=0.1)
    np.testing.assert_allclose(particle_filter.predict(0.2)[:, 0, 2], 0.2 + A * 0.4)


def translation(t):
    X = np.eye(3)
    X[:2, 2] = t
    return X
