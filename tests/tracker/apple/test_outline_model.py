from dataclasses import replace

import fruits
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracker.apple.hypotheses import PER_VIEW, SHARED, Hypotheses, solved, without_views
from tracker.apple.outline_model import OutlineModel
from tracker.apple.outline_views import OutlineModelConfig


def hypothesis_of(fruit, view_count):
    return Hypotheses(
        centre_m=fruit.centre_m[None],
        axis=fruit.axis[None],
        log_radius=np.log([fruit.radius_m]),
        log_aspect=np.log([fruit.aspect]),
        edge_px=np.zeros(1),
        depth=np.ones(1),
        pose_error=np.zeros((1, view_count, PER_VIEW)),
    )


def model_of(fruit, poses, **changes):
    return OutlineModel([fruits.sighting(fruit, p, **changes) for p in poses], OutlineModelConfig())


def residuals(model, hypotheses):
    geometry = model._geometry(hypotheses)
    outline, outline_J = model.outline(hypotheses, *geometry)
    poles, pole_J = model.poles(hypotheses, *geometry)
    return np.concatenate([outline, poles], axis=-1), np.concatenate([outline_J, pole_J], axis=-1)


@settings(max_examples=12)
@given(st.integers(0, 2**32 - 1))
def test_the_true_fruit_has_no_residuals(seed):
    rng = np.random.default_rng(seed)
    fruit = fruits.facing(rng) if seed % 2 else fruits.hanging(rng)
    poses = fruits.approach(4)
    off, _ = residuals(model_of(fruit, poses), hypothesis_of(fruit, len(poses)))
    np.testing.assert_allclose(off, 0.0, atol=1e-7)


@settings(max_examples=12)
@given(st.integers(0, 2**32 - 1))
def test_derivatives_are_those_of_finite_differences(seed):
    rng = np.random.default_rng(seed)
    fruit = fruits.facing(rng) if seed % 2 else fruits.hanging(rng)
    poses = fruits.approach(3)
    model = model_of(fruit, poses)
    spread = [1e-3] * 3 + [0.02, 0.02, 0.1, 0.1, 0.3, 0.02]
    here = hypothesis_of(fruit, len(poses)).moved(
        rng.standard_normal((1, SHARED)) * spread, 0.02 * rng.standard_normal((1, 3, PER_VIEW))
    )
    _, J = residuals(model, here)
    step = 1e-6
    for i in range(SHARED + PER_VIEW):
        shared, per_view = np.zeros((1, SHARED)), np.zeros((1, len(poses), PER_VIEW))
        if i < SHARED:
            shared[0, i] = step
        else:
            per_view[..., i - SHARED] = step
        more, _ = residuals(model, here.moved(shared, per_view))
        less, _ = residuals(model, here.moved(-shared, -per_view))
        expected = (more - less) / (2.0 * step)
        size = max(1.0, np.abs(expected).max())
        np.testing.assert_allclose(J[..., i, :], expected, atol=2e-3 * size)


def test_an_outline_that_is_a_pixel_too_wide_is_a_pixel_off():
    fruit, pose = fruits.apple(fruits.direction(20.0, 70.0)), fruits.approach(2)[0]
    exact = fruits.sighting(fruit, pose).view
    normals = exact.contour_px - exact.centre_px
    rough = exact.contour_px + 0.5 * normals / np.linalg.norm(normals, axis=1, keepdims=True)
    off, _ = residuals(model_of(fruit, [pose], contour_px=rough), hypothesis_of(fruit, 1))
    np.testing.assert_allclose(off[0, 0, :-3], -0.5, atol=0.01)


def test_a_hidden_calyx_must_not_be_where_skin_is_in_sight():
    fruit, poses = fruits.apple((0.8, 0.0, 0.6)), fruits.approach(3)
    hypothesis = hypothesis_of(fruit, 3)
    views = [fruits.sighting(fruit, pose).view for pose in poses]
    assert all(view.calyx_px is not None for view in views)
    hidden, _ = residuals(model_of(fruit, poses, calyx_px=None), hypothesis)
    assert (hidden[0, :, -1] > 1.0).all()
    covered = [
        fruits.sighting(fruit, pose, calyx_px=None, arc_fraction=0.6, skin_px=np.empty((0, 2)))
        for pose in poses
    ]
    no_skin, _ = residuals(OutlineModel(covered, OutlineModelConfig()), hypothesis)
    np.testing.assert_allclose(no_skin[0, :, -1], 0.0)
    turned, _ = residuals(
        model_of(fruit, poses, calyx_px=None), replace(hypothesis, axis=-hypothesis.axis)
    )
    np.testing.assert_allclose(turned[0, :, -1], 0.0)


def test_points_that_are_close_share_their_noise():
    fruit, pose = fruits.apple(), fruits.approach(1)[0]
    coarse = fruits.sighting(fruit, pose)
    dense = fruits.sighting(fruit, pose, contour_px=fruit.outline_px(fruits.K, pose, 4000))
    config = OutlineModelConfig(point_count=4000)
    hypothesis = hypothesis_of(fruit, 1)
    traces = [
        np.trace(OutlineModel([s], config).information(hypothesis)[0]) for s in (coarse, dense)
    ]
    assert traces[1] < 1.5 * traces[0]


def test_views_are_eliminated_as_from_the_whole_system():
    fruit, poses = fruits.apple(fruits.direction(10.0, 0.0)), fruits.approach(3)
    hypothesis = hypothesis_of(fruit, 3).moved(np.full((1, SHARED), 1e-3), np.zeros((1, 3, 6)))
    system = model_of(fruit, poses).evaluate(hypothesis, 5.0)
    count = SHARED + 3 * PER_VIEW
    whole, gradient = np.zeros((count, count)), np.zeros(count)
    whole[:SHARED, :SHARED] = system.shared_matrix[0]
    gradient[:SHARED] = system.shared_gradient[0]
    for v in range(3):
        place = slice(SHARED + v * PER_VIEW, SHARED + (v + 1) * PER_VIEW)
        whole[place, place] = system.view_matrix[0, v]
        whole[place, :SHARED] = system.mixed_matrix[0, v]
        whole[:SHARED, place] = system.mixed_matrix[0, v].T
        gradient[place] = system.view_gradient[0, v]
    step = np.linalg.solve(whole, gradient)
    matrix, reduced, eliminated, rest = without_views(system)
    shared = solved(matrix, reduced[..., None])[0, :, 0]
    np.testing.assert_allclose(shared, step[:SHARED], rtol=1e-6, atol=1e-12)
    views = rest[0] - eliminated[0] @ shared
    np.testing.assert_allclose(views.ravel(), step[SHARED:], rtol=1e-5, atol=1e-9)


def test_settings_are_checked():
    with pytest.raises(ValueError, match="contour_sigma_px must be a positive number, got -1"):
        OutlineModelConfig(contour_sigma_px=-1)
    with pytest.raises(ValueError, match="point_count must be 8 or greater, got 3"):
        OutlineModelConfig(point_count=3)
