import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tracker.bearing_only.target_models import acceleration_noise, straight_transition, turn


def state(rate):
    return np.array([1.0, 2.0, 3.0, 1.5, -0.5, 0.2, rate])


@given(st.sampled_from([0.0, 1e-9, 1e-4, 0.0199, 0.0201, -0.3, 2.0]))
def test_the_jacobian_of_a_turn_is_that_of_finite_differences(rate):
    x, step = state(rate), 1e-6
    _, F = turn(x, 0.05)
    numeric = [(turn(x + e, 0.05)[0] - turn(x - e, 0.05)[0]) / (2 * step) for e in step * np.eye(7)]
    assert np.allclose(F, np.transpose(numeric), atol=1e-8)


def test_a_turn_of_rate_zero_is_a_straight_line():
    moved, _ = turn(state(0.0), 0.05)
    assert np.allclose(moved[:6], straight_transition(0.05) @ state(0.0)[:6])


def test_a_turn_closes_its_circle():
    x = state(2.0 * np.pi / 5.0)
    for _ in range(100):
        x, _ = turn(x, 0.05)
    assert np.allclose(x[[0, 1, 3, 4]], state(0.0)[[0, 1, 3, 4]], atol=1e-9)
    assert np.isclose(x[2], 3.0 + 5.0 * 0.2)


def test_the_noise_is_that_of_an_acceleration():
    G = np.concatenate([0.05**2 / 2 * np.eye(3), 0.05 * np.eye(3)])
    assert np.allclose(acceleration_noise(0.05, 1.5), 1.5**2 * G @ G.T)
