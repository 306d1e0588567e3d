import numpy as np
import pytest

from tracker.affine import aff2
from tracker.affine.likelihood import LikelihoodConfig, TemplateObservation, climb
from tracker.affine.patches import Layers, PatchMatcher
from tracker.belt.image import ArrayImage

TOP = aff2.similarity(20.0, 0.3, np.array([50.0, 40.0]))


@pytest.fixture
def observe(view, scene, template):
    """Observation of a box at (0.5, 0, 0.4), with settings to vary."""

    def build(gain=1.0, offset=0.0, unit_px=None, occluder=None, sigma=0.3, **settings):
        image = view.rectify(ArrayImage(*scene.render(0.5, 0.0, 0.4, occluder)))
        layers = Layers.of(gain * image.grey + offset, image.visibility)
        config = LikelihoodConfig(**settings)
        return TemplateObservation(PatchMatcher(template), layers, config, sigma, unit_px)

    return build


def test_gain_and_offset_do_not_matter(observe, true_warp):
    warp = true_warp(0.5, 0.0, 0.4)[None]
    np.testing.assert_allclose(
        observe().fit(warp).ncc, observe(gain=0.3, offset=20).fit(warp).ncc, atol=0.01
    )


def test_gauss_newton_finds_back_to_the_truth(observe, true_warp):
    truth = true_warp(0.5, 0.0, 0.4)
    offsets = 0.02 * np.random.default_rng(0).standard_normal((40, 6))
    observation, warps = observe(), aff2.perturb(truth, offsets)
    remaining = np.linalg.norm(aff2.difference(truth, climb(observation, warps, 8)), axis=1)
    assert np.median(remaining / np.linalg.norm(offsets, axis=1)) < 0.2


def test_gradient_is_the_derivative_of_the_likelihood(observe, true_warp):
    """To the accuracy of the inverse-compositional approximation."""
    truth = true_warp(0.5, 0.0, 0.4)
    observation = observe(huber_threshold=100.0)
    for axis in range(2, 6):
        e = np.zeros((21, 6))
        e[:, axis] = np.linspace(-0.025, 0.025, 21)
        values = observation.log_likelihood(aff2.perturb(truth, e))
        gradient, _ = observation.linearise(aff2.perturb(truth, e))
        quadratic = np.polynomial.Polynomial.fit(e[:, axis], values, 2).convert().coef[2]
        slope = np.polynomial.Polynomial.fit(e[:, axis], gradient[:, axis], 1).convert().coef[1]
        assert 2 * quadratic == pytest.approx(slope, rel=0.4)


def test_information_is_symmetric_and_positive(observe, true_warp, unit_px):
    warps = np.tile(true_warp(0.5, 0.0, 0.4), (3, 1, 1))
    _, information = observe(unit_px=unit_px).linearise(warps)
    np.testing.assert_allclose(information, np.swapaxes(information, 1, 2))
    assert np.linalg.eigvalsh(information).min() > 0


def test_known_size_is_a_gaussian_on_shape(observe, scene, true_warp, unit_px):
    truth = true_warp(0.5, 0.0, 0.4)
    stretched = aff2.perturb(truth, np.array([0.03, 0, 0, 0, 0, 0]))[None]
    likelihoods = []
    for known in (None, unit_px):
        scene.rng = np.random.default_rng(0)  # the same noise in both images
        likelihoods.append(observe(unit_px=known, shape_std=0.01).log_likelihood(stretched)[0])
    assert likelihoods[0] - likelihoods[1] == pytest.approx(0.5 * 9.0, abs=1e-6)


def test_hidden_pixels_neither_reward_nor_punish(observe, true_warp):
    """Covering a third of a well matched patch changes its likelihood little."""
    warp = true_warp(0.5, 0.0, 0.4)[None]
    hidden = observe(occluder=(0.5, 0.72, -0.12, 0.0, 0.2))
    fit = hidden.fit(warp)
    assert 0.3 < fit.visible_fraction[0] < 0.9
    assert fit.ncc[0] > 0.9
    assert abs(hidden.log_likelihood(warp) - observe().log_likelihood(warp))[0] < 5.0


def test_a_warp_outside_the_image_has_a_finite_likelihood(observe):
    away = aff2.similarity(40.0, 0.0, [1e5, 1e5])[None]
    fit = observe().fit(away)
    assert fit.visible_fraction[0] == 0.0
    assert fit.ncc[0] == 0.0
    assert np.isfinite(observe().log_likelihood(away)).all()


@pytest.mark.parametrize(
    ("field", "value"),
    [("initial_sigma", 0.0), ("independent_pixel_count", np.nan), ("sigma_memory", 1.0)],
)
def test_bad_settings_are_refused(field, value):
    with pytest.raises(ValueError, match=field):
        LikelihoodConfig(**{field: value})


class Hill:
    """A log-likelihood that is quadratic around TOP, and flat along some directions."""

    def __init__(self, information):
        self._information = np.diag(information).astype(float)

    def linearise(self, warps, iteration=0):
        del iteration
        away = aff2.difference(TOP, warps)
        return -away @ self._information, np.tile(self._information, (len(warps), 1, 1))


def test_climbing_ends_at_the_top():
    starts = aff2.perturb(TOP, 0.1 * np.random.default_rng(0).standard_normal((20, 6)))
    ends = climb(Hill([1e4] * 6), starts, 6)
    np.testing.assert_allclose(aff2.difference(TOP, ends), 0.0, atol=1e-6)


def test_what_the_image_does_not_tell_stays():
    start = aff2.perturb(TOP, np.array([0, 0, 0, 0, 0.1, 0.1]))
    end = aff2.difference(TOP, climb(Hill([1e4] * 5 + [0.0]), start[None], 8)[0])
    np.testing.assert_allclose(end, [0, 0, 0, 0, 0, 0.1], atol=1e-3)


def test_no_step_of_a_climb_is_long():
    start = aff2.perturb(TOP, np.array([0, 0, 0, 0, 5.0, 0]))
    end = climb(Hill([1e4] * 6), start[None], 1)[0]
    assert aff2.difference(TOP, end)[4] == pytest.approx(4.7, abs=1e-6)
