import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker.bearing_only.measurements import PinholeCamera, PoseBelief, TargetBelief
from tracker.bearing_only.observation import view_target
from tracker.bearing_only.pilot import TARGET_FILTERS
from tracker.bearing_only.target_filter import (
    TargetNoise,
    acceleration_noise,
    correct,
    straight_transition,
    turn,
)
from tracker.bearing_only.target_mixture import MixtureFilter
from tracker.geometry import rotation_of_vector

CAMERA, DT = PinholeCamera(), 0.05
ZERO = np.zeros((6, 6))
SEEN = np.ones((), bool)


def prior(offset=(0.0, 0.0, 0.0)):
    P = np.diag([2.0, 2.0, 2.0, 1.0, 1.0, 1.0]) ** 2
    return TargetBelief(np.array([10.0, 0.0, 0.0]) + offset, np.zeros(3), P)


def sideways(k):
    """A camera that swings to and fro and looks along x."""
    return PoseBelief(
        np.array([0.0, 3.0 * np.sin(0.1 * k), 1.0 * np.cos(0.13 * k)]), np.eye(3), ZERO
    )


def follow(make, way, steps=200, noise=0.0):
    rng = np.random.default_rng(0)
    target_filter = make(CAMERA, TargetNoise(), prior((1.5, 0.2, -0.1)), DT)
    for k in range(steps):
        if k:
            target_filter.predict()
        view = view_target(CAMERA, sideways(k), way(k * DT))
        target_filter.update(view.pixel + noise * rng.normal(size=2), sideways(k), SEEN)
    return target_filter, target_filter.belief.position_m - way((steps - 1) * DT)


def line(t):
    return np.array([10.0 + 0.3 * t, 0.2 * t, -0.1 * t])


def circle(t):
    return np.array([10.0 + np.sin(0.5 * t), 1.0 - np.cos(0.5 * t), 0.0])


@pytest.mark.parametrize("name", TARGET_FILTERS)
def test_every_filter_finds_a_straight_target(name):
    target_filter, error = follow(TARGET_FILTERS[name], line, noise=1.0)
    assert np.linalg.norm(error) < 0.4
    P = target_filter.belief.covariance[:3, :3]
    assert error @ np.linalg.solve(P, error) < 16.0
    assert (np.linalg.eigvalsh(target_filter.belief.covariance) > 0.0).all()


@pytest.mark.parametrize("name", ["turn", "mixture"])
def test_a_turn_model_beats_the_straight_one_on_a_circle(name):
    straight = np.linalg.norm(follow(TARGET_FILTERS["straight"], circle, 300)[1])
    assert np.linalg.norm(follow(TARGET_FILTERS[name], circle, 300)[1]) < straight


def test_the_mixture_believes_in_the_turn_on_a_circle():
    target_filter, _ = follow(MixtureFilter, circle, 400, 0.3)
    assert isinstance(target_filter, MixtureFilter)
    assert np.isclose(target_filter.weight.sum(), 1.0)
    assert target_filter.weight[1] > 0.5


@pytest.mark.parametrize("name", TARGET_FILTERS)
def test_an_unseen_target_is_only_predicted(name):
    target_filter = TARGET_FILTERS[name](CAMERA, TargetNoise(), prior(), DT)
    target_filter.predict()
    before = target_filter.belief
    target_filter.update(np.array([1e3, 1e3]), sideways(0), np.zeros((), bool))
    assert np.allclose(target_filter.belief.position_m, before.position_m)
    assert np.allclose(target_filter.belief.covariance, before.covariance)
    behind = PoseBelief(np.zeros(3), rotation_of_vector(np.array([0.0, 0.0, np.pi])), ZERO)
    target_filter.update(np.array([320.0, 240.0]), behind, SEEN)
    assert np.allclose(target_filter.belief.position_m, before.position_m)


@pytest.mark.parametrize("name", TARGET_FILTERS)
def test_several_targets_at_once_are_each_as_alone(name):
    offsets = [(0.0, 0.0, 0.0), (1.0, -0.3, 0.2)]

    def run(beliefs, leading):
        target_filter = TARGET_FILTERS[name](CAMERA, TargetNoise(), beliefs, DT)
        for k in range(20):
            target_filter.predict()
            pixel = np.broadcast_to([320.0 + k, 240.0], (*leading, 2))
            pose = PoseBelief(*(np.broadcast_to(a, (*leading, *a.shape)) for a in
                                (sideways(k).position_m, np.eye(3), ZERO)))  # fmt: skip
            target_filter.update(pixel, pose, np.ones(leading, bool))
        return target_filter.belief.position_m

    beliefs = [prior(offset) for offset in offsets]
    both = TargetBelief(*(np.stack([getattr(b, n) for b in beliefs]) for n in
                          ("position_m", "velocity_mps", "covariance")))  # fmt: skip
    assert np.allclose(run(both, (2,)), [run(b, ()) for b in beliefs], atol=1e-9)


def test_one_update_by_hand():
    """A pixel 32 columns to the right, all variances known: K = P H^T S^-1, [Wu2022] Eq. 10."""
    pose, P = PoseBelief(np.zeros(3), np.eye(3), ZERO), np.diag([1.0, 4.0, 1.0])
    view = view_target(CAMERA, pose, np.array([10.0, 0.0, 0.0]))
    new = correct(np.array([10.0, 0.0, 0.0]), P, view, np.array([352.0, 240.0]), 9.0 * np.eye(2))
    # A metre to the left is -32 columns at 10 m: S = 32^2 * 4 + 9, K = -32 * 4 / S.
    S = 32.0**2 * 4.0 + 9.0
    assert np.isclose(new.innovation_covariance[0, 0], S)
    assert np.allclose(new.state, [10.0, -32.0 * 4.0 / S * 32.0, 0.0])
    assert np.isclose(new.covariance[1, 1], 4.0 * 9.0 / S)
    assert np.isclose(new.covariance[0, 0], 1.0)


def test_doubt_about_the_pose_widens_the_innovation():
    from tracker.bearing_only.target_filter import measurement_noise

    sure, unsure = sideways(0), PoseBelief(np.zeros(3), np.eye(3), 0.01 * np.eye(6))
    view = view_target(CAMERA, unsure, np.array([10.0, 0.0, 0.0]))
    assert np.allclose(measurement_noise(view, sure, 3.0), 9.0 * np.eye(2))
    # Position 0.01 m^2 at 32 px/m, rotation 0.01 rad^2 at 320 px/rad.
    assert np.isclose(measurement_noise(view, unsure, 3.0)[0, 0], 9.0 + 10.24 + 1024.0)


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
