"""The analytic gradients against finite differences, and what the paper's Eq. 36 lacks."""

import numpy as np
import pytest

from tracker.bearing_only.measurements import PinholeCamera, PoseBelief, TargetBelief
from tracker.bearing_only.observability import gain_gradient
from tracker.bearing_only.observation import view_target
from tracker.geometry import rotation_of_vector

CAMERA = PinholeCamera()


def gain(kind, pose, target):
    """J of `gain_gradient` at the pose, in plain NumPy."""
    H, P = view_target(CAMERA, pose, target.position_m).by_target, target.covariance
    S = H @ P[:3, :3] @ H.T + 9.0 * np.eye(2)
    if kind == "log-det":
        return 0.5 * np.linalg.slogdet(S / 9.0)[1]
    return 0.5 * np.trace(H @ (P @ P)[:3, :3] @ H.T @ np.linalg.inv(S))


def random_case(rng):
    position, R = rng.normal(0.0, 5.0, 3), rotation_of_vector(rng.normal(0.0, 1.0, 3))
    in_body = np.array([rng.uniform(3.0, 30.0), *rng.normal(0.0, 2.0, 2)])
    A = rng.normal(0.0, 1.0, (6, 6))
    target = TargetBelief(position + R @ in_body, np.zeros(3), A @ A.T)
    return PoseBelief(position, R, np.zeros((6, 6))), target


def finite_difference(kind, pose, target, step):
    """Central differences with Richardson's extrapolation."""

    def at(displacement):
        moved = PoseBelief(pose.position_m + displacement, pose.R_world_body, pose.covariance)
        return gain(kind, moved, target)

    def central(h):
        return np.array([(at(h * e) - at(-h * e)) / (2.0 * h) for e in np.eye(3)])

    return (4.0 * central(step / 2.0) - central(step)) / 3.0


@pytest.mark.parametrize("kind", ["trace", "log-det"])
def test_the_gradient_is_that_of_finite_differences(kind):
    rng = np.random.default_rng(0)
    for _ in range(200):
        pose, target = random_case(rng)
        g = gain_gradient(kind, CAMERA, pose, target, 3.0)
        expected = finite_difference(kind, pose, target, 1e-3)
        assert np.linalg.norm(g - expected) <= 1e-6 * np.linalg.norm(expected)


@pytest.mark.parametrize("kind", ["trace", "log-det"])
def test_several_at_once_are_each_as_alone(kind):
    cases = [random_case(np.random.default_rng(seed)) for seed in range(5)]
    pose = PoseBelief(*(np.stack([getattr(c[0], n) for c in cases]) for n in
                        ("position_m", "R_world_body", "covariance")))  # fmt: skip
    target = TargetBelief(*(np.stack([getattr(c[1], n) for c in cases]) for n in
                            ("position_m", "velocity_mps", "covariance")))  # fmt: skip
    together = gain_gradient(kind, CAMERA, pose, target, 3.0)
    alone = [gain_gradient(kind, CAMERA, *case, 3.0) for case in cases]
    assert np.allclose(together, alone, rtol=1e-12)


def test_on_the_optical_axis_dS_is_singular_and_the_gradient_is_still_finite():
    """[Wu2022] Eq. 36 writes det(dS) dS^-1, which is 0 times infinity here.

    With the covariance aligned to the line of sight the lateral gradient is zero: a saddle.
    """
    P = np.diag([4.0, 0.01, 0.01, 1.0, 1.0, 1.0])
    pose = PoseBelief(np.zeros(3), np.eye(3), np.zeros((6, 6)))
    g = gain_gradient(
        "trace", CAMERA, pose, TargetBelief(np.array([10.0, 0, 0]), np.zeros(3), P), 3.0
    )
    assert np.isfinite(g).all()
    assert np.allclose(g[1:], 0.0, atol=1e-12)


def test_the_view_s_jacobians_are_those_of_finite_differences():
    rng = np.random.default_rng(1)
    for _ in range(50):
        pose, target = random_case(rng)
        view = view_target(CAMERA, pose, target.position_m)
        assert view.is_in_front
        steps = 1e-6 * np.eye(3)
        by_target = [
            (view_target(CAMERA, pose, target.position_m + e).pixel
             - view_target(CAMERA, pose, target.position_m - e).pixel) / 2e-6
            for e in steps
        ]  # fmt: skip
        assert np.allclose(view.by_target, np.transpose(by_target), rtol=1e-4, atol=1e-4)
        by_turn = [
            (view_target(CAMERA, turned(pose, e), target.position_m).pixel
             - view_target(CAMERA, turned(pose, -e), target.position_m).pixel) / 2e-6
            for e in steps
        ]  # fmt: skip
        assert np.allclose(view.by_pose[:, 3:], np.transpose(by_turn), rtol=1e-4, atol=1e-2)
        assert np.allclose(view.by_pose[:, :3], -view.by_target)


def turned(pose, phi):
    R = pose.R_world_body @ rotation_of_vector(phi)
    return PoseBelief(pose.position_m, R, pose.covariance)


def test_the_information_is_what_the_update_takes_off_the_volume():
    """det(P+) = det(P-) det(R) / det(S): the log-det gain is the volume of [Wu2022] Eq. 16."""
    from tracker.bearing_only.target_filter import correct

    pose, target = random_case(np.random.default_rng(4))
    view = view_target(CAMERA, pose, target.position_m)
    state = np.concatenate([target.position_m, target.velocity_mps])
    new = correct(state, target.covariance, view, view.pixel, 9.0 * np.eye(2))
    logs = [np.linalg.slogdet(P)[1] for P in (target.covariance, new.covariance)]
    assert np.isclose(gain("log-det", pose, target), 0.5 * (logs[0] - logs[1]))
    trace = np.trace(target.covariance[:, :]) - np.trace(new.covariance)
    whole = 0.5 * np.trace(
        (target.covariance @ target.covariance)[:3, :3]
        @ view.by_target.T @ np.linalg.inv(new.innovation_covariance) @ view.by_target
    )  # fmt: skip
    assert np.isclose(whole, 0.5 * trace)
    assert np.isclose(gain("trace", pose, target), whole)
