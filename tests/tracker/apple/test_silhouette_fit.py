from dataclasses import replace

import fruits
import numpy as np
import pytest

from tracker.apple.attitude import angle_between_deg, axis_error_deg
from tracker.apple.outline_views import OutlineModelConfig
from tracker.apple.silhouette_fit import SilhouetteFitConfig, fit_silhouettes
from tracker.apple.single_view import measure
from tracker.apple.view import FruitStatus, FruitView, Sighting

POSES = fruits.approach()


def noisy_views(fruit, rng, poses=POSES, **noise):
    return [fruits.noisy(fruit, pose, rng, **noise) for pose in poses]


@pytest.mark.parametrize("aspect", [0.85, 0.93])
@pytest.mark.parametrize("tilt_deg", [5.0, 25.0])
def test_exact_outlines_give_the_exact_fruit(aspect, tilt_deg):
    """All but what the prior of the aspect pulls, which is little against outlines."""
    fruit = fruits.apple(fruits.direction(tilt_deg, 30.0), aspect)
    fit = fit_silhouettes([fruits.sighting(fruit, pose) for pose in POSES])
    assert axis_error_deg(fit.axis, fruit.axis) < 0.15
    assert fit.fruit.aspect == pytest.approx(aspect, abs=0.003)
    assert fit.fruit.radius_m == pytest.approx(fruit.radius_m, rel=0.01)
    np.testing.assert_allclose(fit.fruit.centre_m, fruit.centre_m, atol=2e-3)
    assert fit.residual_px < 0.02


@pytest.mark.parametrize(
    ("make", "aspect", "leaf_count", "limit_deg"),
    [
        (fruits.hanging, 0.85, 0, 1.0),
        (fruits.hanging, 0.93, 0, 1.5),
        (fruits.facing, 0.85, 0, 1.0),
        (fruits.hanging, 0.85, 3, 2.5),
        (fruits.facing, 0.85, 3, 2.0),
    ],
)
def test_the_axis_from_noisy_outlines(make, aspect, leaf_count, limit_deg):
    """Half a degree of pose noise, and an outline 0.3 px too wide, with 0.25 px of noise."""
    errors, singles = [], []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        fruit = make(rng, aspect=aspect)
        leaves = fruits.leaves_before(rng, leaf_count)
        views = noisy_views(fruit, rng, leaves=leaves)
        errors.append(axis_error_deg(fit_silhouettes(views).axis, fruit.axis))
        singles.append(np.mean([axis_error_deg(measure(v).axis, fruit.axis) for v in views]))
    assert np.median(errors) < limit_deg
    assert np.median(errors) < 0.6 * np.median(singles)


def test_its_uncertainty_is_honest():
    """Squared errors over predicted variances are 2 on average; the models are a little wary."""
    ratios = []
    for seed in range(24):
        rng = np.random.default_rng(100 + seed)
        fruit = fruits.hanging(rng, aspect=0.88)
        fit = fit_silhouettes(noisy_views(fruit, rng))
        error = np.radians(axis_error_deg(fit.axis, fruit.axis))
        ratios.append(2.0 * error**2 / np.trace(fit.axis_covariance))
    assert 0.2 < np.mean(ratios) < 3.0


def test_a_calyx_in_sight_decides_the_sign():
    rng = np.random.default_rng(3)
    fruit = fruits.apple((0.7, 0.1, -0.7))  # stem down and away
    fit = fit_silhouettes(noisy_views(fruit, rng))
    assert angle_between_deg(fit.axis, fruit.axis) < 2.0
    assert fit.is_sign_seen


def test_bare_skin_where_the_calyx_would_be_decides_the_sign():
    fruit = fruits.apple((-0.7, 0.0, -0.7))  # stem towards the camera and down
    views = [fruits.sighting(fruit, pose, calyx_px=None) for pose in POSES]
    assert angle_between_deg(fit_silhouettes(views).axis, fruit.axis) < 2.0


def test_outlines_alone_leave_the_sign_to_what_is_up():
    fruit = fruits.apple(fruits.direction(3.0, 90.0))
    views = [
        fruits.sighting(fruit, p, calyx_px=None, arc_fraction=0.9, skin_px=np.empty((0, 2)))
        for p in POSES
    ]
    fit = fit_silhouettes(views)
    assert fit.axis[2] > 0.9
    assert not fit.is_sign_seen
    config = SilhouetteFitConfig(up=(0.0, 0.0, -1.0))
    assert fit_silhouettes(views, config).axis[2] < -0.9


@pytest.mark.parametrize(
    "wrong",
    [
        {"aspect": 0.92, "aspect_sigma": 1e-4},
        {"pose_sigma_rad": 1e-5, "pose_sigma_m": 1e-6},
    ],
)
def test_what_the_fit_must_not_take_for_known(wrong):
    """An aspect 0.03 off, or poses that are half a degree off, put a hanging apple far off."""
    errors: dict[str, list[float]] = {"fitted": [], "known": []}
    for seed in range(5):
        rng = np.random.default_rng(900 + seed)
        fruit = fruits.hanging(rng, aspect=0.95)
        views = noisy_views(fruit, rng)
        known = SilhouetteFitConfig(model=OutlineModelConfig(**wrong))
        for name, config in (("fitted", None), ("known", known)):
            errors[name].append(axis_error_deg(fit_silhouettes(views, config).axis, fruit.axis))
    assert np.median(errors["fitted"]) < 2.0
    assert np.median(errors["known"]) > 10.0


def test_a_stretch_of_wrong_outline_pulls_little():
    rng = np.random.default_rng(5)
    fruit = fruits.hanging(rng)
    wrong = []
    for sighting in noisy_views(fruit, rng):
        contour = np.array(sighting.view.contour_px)
        contour[:18] += 8.0 * (sighting.view.centre_px - contour[:18]) / 50.0
        wrong.append(replace(sighting, view=replace(sighting.view, contour_px=contour)))
    assert axis_error_deg(fit_silhouettes(wrong).axis, fruit.axis) < 3.0


def test_ellipses_do_where_no_outline_points_are_told():
    fruit = fruits.apple(fruits.direction(15.0, 10.0))
    views = [fruits.sighting(fruit, pose, contour_px=np.empty((0, 2))) for pose in POSES]
    assert axis_error_deg(fit_silhouettes(views).axis, fruit.axis) < 0.5


def test_views_without_a_fruit_are_left_out():
    fruit = fruits.apple(fruits.direction(15.0, 10.0))
    views = [fruits.sighting(fruit, pose) for pose in POSES]
    none = [Sighting(FruitView(s), fruits.K, POSES[0]) for s in FruitStatus if s != "found"]
    assert fit_silhouettes(none) is None
    assert fit_silhouettes([]) is None
    np.testing.assert_array_equal(
        fit_silhouettes([*none, *views]).axis, fit_silhouettes(views).axis
    )


def test_one_view_is_enough_for_an_answer_and_tells_how_little_it_knows():
    fruit = fruits.apple(fruits.direction(15.0, 0.0))
    one = fit_silhouettes([fruits.sighting(fruit, POSES[4])])
    many = fit_silhouettes([fruits.sighting(fruit, pose) for pose in POSES])
    assert np.isfinite(one.axis).all()
    assert one.axis_sigma_deg > 5.0 * many.axis_sigma_deg


def test_more_views_are_more_certain():
    fruit = fruits.apple(fruits.direction(15.0, 0.0), 0.9)
    views = [fruits.sighting(fruit, pose) for pose in POSES]
    sigmas = [fit_silhouettes(views[:n]).axis_sigma_deg for n in (3, 5, 8)]
    assert sigmas[0] > sigmas[1] > sigmas[2]


def test_hypotheses_are_ordered_and_apart():
    rng = np.random.default_rng(11)
    fit = fit_silhouettes(noisy_views(fruits.hanging(rng, aspect=0.95), rng, POSES[:2]))
    chances = [hypothesis.probability for hypothesis in fit.hypotheses]
    assert sum(chances) == pytest.approx(1.0)
    assert chances == sorted(chances, reverse=True)
    axes = np.array([hypothesis.fruit.axis for hypothesis in fit.hypotheses])
    for i in range(len(axes)):
        assert (axis_error_deg(axes[i], np.delete(axes, i, axis=0)) > 4.0).all()


def test_the_same_images_give_the_same_answer():
    rng = np.random.default_rng(7)
    views = noisy_views(fruits.hanging(rng), rng)
    np.testing.assert_array_equal(fit_silhouettes(views).axis, fit_silhouettes(views).axis)


def test_settings_are_checked():
    with pytest.raises(ValueError, match="start_count must be 1 or greater, got 0"):
        SilhouetteFitConfig(start_count=0)
    with pytest.raises(ValueError, match="aspect must be a positive number, got nan"):
        SilhouetteFitConfig(model=OutlineModelConfig(aspect=float("nan")))
