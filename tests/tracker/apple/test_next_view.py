import math
from dataclasses import replace

import fruits
import numpy as np
import pytest

from tracker.apple.attitude import angle_between_deg, axis_error_deg, unit
from tracker.apple.next_view import (
    NextViewConfig,
    looking_at,
    predicted_sigmas_deg,
    views_around,
)
from tracker.apple.silhouette_fit import SilhouetteFit, fit_silhouettes


@pytest.fixture(scope="module")
def fruit():
    return fruits.apple(fruits.direction(20.0, 20.0), aspect=0.9)


@pytest.fixture(scope="module")
def fit(fruit):
    return fit_silhouettes([fruits.sighting(fruit, p) for p in fruits.approach(4, arc_deg=8.0)])


def test_a_view_is_predicted_to_leave_what_it_leaves(fit, fruit):
    """The uncertainty that is predicted is that of the fit with this view, roughly."""
    first = fruits.approach(4, arc_deg=8.0)
    candidates = views_around(fruits.CENTRE_M, np.array([-1.0, 0.0, 0.0]), 0.3, 1.0, 6)
    predicted = predicted_sigmas_deg(fit, candidates, fruits.K, fruits.SIZE_PX)
    after = [
        fit_silhouettes([fruits.sighting(fruit, p) for p in (*first, pose)]).axis_sigma_deg
        for pose in candidates
    ]
    assert (predicted < fit.axis_sigma_deg).all()
    np.testing.assert_allclose(predicted, after, rtol=0.35)


def test_the_best_view_beats_going_on_straight():
    chosen, straight = [], []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        fruit = fruits.hanging(rng, aspect=0.93)
        views = [fruits.noisy(fruit, p, rng) for p in fruits.approach(4, arc_deg=6.0)]
        fit = fit_silhouettes(views)
        back = views[-1].pose.position_m - fit.fruit.centre_m
        candidates = views_around(fit.fruit.centre_m, back, 0.3, math.radians(50.0), 30)
        best = np.argmin(predicted_sigmas_deg(fit, candidates, fruits.K, fruits.SIZE_PX))
        for errors, pose in ((chosen, candidates[best]), (straight, candidates[0])):
            more = fit_silhouettes([*views, fruits.noisy(fruit, pose, rng)])
            errors.append(axis_error_deg(more.axis, fruit.axis))
    assert np.mean(chosen) < 0.7 * np.mean(straight)


def test_a_view_that_would_cut_the_fruit_is_never_chosen(fit):
    good = looking_at(fruits.CENTRE_M, fruits.CENTRE_M - [0.4, 0.0, 0.0])
    too_near = looking_at(fruits.CENTRE_M, fruits.CENTRE_M - [0.09, 0.0, 0.0])
    aside = looking_at(
        fruits.CENTRE_M + np.array([0.0, 0.3, 0.0]), fruits.CENTRE_M - [0.4, 0.0, 0.0]
    )
    behind = looking_at(fruits.CENTRE_M - [0.9, 0.0, 0.0], fruits.CENTRE_M - [0.4, 0.0, 0.0])
    bad = [too_near, aside, behind]
    sigmas = predicted_sigmas_deg(fit, [*bad, good], fruits.K, fruits.SIZE_PX)
    assert np.isinf(sigmas[:3]).all()
    assert np.isfinite(sigmas[3])


def test_an_explanation_that_the_picture_rules_out_does_not_break_the_choice(fit):
    """Its outline is elsewhere, and normals of the picture's outline graze it or miss it."""
    best = fit.hypotheses[0]
    poses = views_around(fruits.CENTRE_M, np.array([-1.0, 0.0, 0.0]), 0.3, 0.8, 5)
    alone = SilhouetteFit((replace(best, probability=1.0),), 0.1, True)
    expected = predicted_sigmas_deg(alone, poses, fruits.K, fruits.SIZE_PX)
    for aside in np.linspace(0.2, 2.0, 10):
        shift = np.array([0.0, aside * best.fruit.radius_m, 0.01])
        fruit = replace(best.fruit, centre_m=best.fruit.centre_m + shift)
        other = replace(best, fruit=fruit, probability=1e-6)
        both = SilhouetteFit((replace(best, probability=1.0 - 1e-6), other), 0.1, True)
        sigmas = predicted_sigmas_deg(both, poses, fruits.K, (1280, 960))
        assert np.isfinite(sigmas).all()
        np.testing.assert_allclose(sigmas, expected, rtol=0.01)


def test_leaves_make_a_view_worth_less(fit):
    pose = [looking_at(fruits.CENTRE_M, fruits.CENTRE_M + np.array([0.0, -0.3, 0.1]))]
    clear = predicted_sigmas_deg(fit, pose, fruits.K, fruits.SIZE_PX)
    half = NextViewConfig(visible_share=0.5)
    assert predicted_sigmas_deg(fit, pose, fruits.K, fruits.SIZE_PX, half) > clear


def test_poses_around_a_fruit_look_at_it_from_within_the_cap():
    toward = unit(np.array([-1.0, 0.3, 0.2]))
    poses = views_around(fruits.CENTRE_M, toward, 0.3, math.radians(40.0), 25)
    assert len(poses) == 25
    back = np.array([pose.position_m - fruits.CENTRE_M for pose in poses])
    np.testing.assert_allclose(np.linalg.norm(back, axis=1), 0.3)
    aside = angle_between_deg(unit(back), toward)
    np.testing.assert_allclose(aside[[0, -1]], [0.0, 40.0], atol=1e-6)
    assert (aside <= 40.0 + 1e-6).all()
    for pose, away in zip(poses, back, strict=True):
        np.testing.assert_allclose(pose.rotation[:, 2], -unit(away), atol=1e-12)
        assert pose.rotation[2, 0] == pytest.approx(0.0)
        assert pose.rotation[2, 1] < 0.0


def test_a_camera_that_looks_straight_up_is_a_pose_as_well():
    pose = looking_at(fruits.CENTRE_M, fruits.CENTRE_M - [0.0, 0.0, 0.3])
    np.testing.assert_allclose(pose.rotation[:, 2], [0.0, 0.0, 1.0])


def test_settings_are_checked():
    with pytest.raises(ValueError, match=r"visible_share must be in \[0, 1\], got 2"):
        NextViewConfig(visible_share=2)
    with pytest.raises(ValueError, match="count must be 1 or greater, got 0"):
        views_around(fruits.CENTRE_M, np.array([1.0, 0.0, 0.0]), 0.3, 1.0, 0)
