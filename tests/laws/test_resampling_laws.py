"""Laws of resampling: unbiased copies; improved resampling never loses observation weight."""

import numpy as np
import pytest

from tracker.affine import aff2
from tracker.affine.resampling import (
    RESAMPLERS,
    CombinationConfig,
    Particles,
    ResamplingContext,
    multinomial_indices,
    residual_indices,
    systematic_indices,
)
from tracker.affine.state_space import STATE_SPACES

INDEX_DRAWS = {
    "multinomial": multinomial_indices,
    "systematic": systematic_indices,
    "residual": residual_indices,
}


class Peak:
    """Observation whose likelihood falls with the distance from `centre`."""

    def __init__(self, centre, sharpness=50.0):
        self.centre, self.sharpness = centre, sharpness

    def log_likelihood(self, warps):
        return -self.sharpness * (aff2.difference(self.centre, warps) ** 2).sum(axis=1)

    def linearise(self, warps, iteration=0):
        raise AssertionError("resampling must not linearise")


def cloud(observation, count=100, spread=0.2, seed=0):
    rng = np.random.default_rng(seed)
    warps = aff2.exp(spread * rng.standard_normal((count, 6)))
    log_likelihoods = observation.log_likelihood(warps)
    log_weights = log_likelihoods - np.logaddexp.reduce(log_likelihoods)
    return Particles(warps, warps.copy(), log_weights, log_likelihoods)


def context(observation, **reading):
    combination = CombinationConfig(**reading)
    return make_context(observation, 1e-3 * np.eye(6), combination)


def make_context(observation, covariance, combination):
    variances = np.full(6, 4e-3)
    return ResamplingContext(STATE_SPACES["group"], observation, covariance, variances, combination)


@pytest.mark.parametrize("name", INDEX_DRAWS)
def test_copies_are_unbiased(name):
    rng = np.random.default_rng(1)
    weights = rng.random(12) ** 3
    weights /= weights.sum()
    draws = 4000
    counts = sum(np.bincount(INDEX_DRAWS[name](weights, rng), minlength=12) for _ in range(draws))
    standard_error = np.sqrt(12 * weights * (1 - weights) / draws)
    np.testing.assert_array_less(np.abs(counts / draws - 12 * weights), 5 * standard_error + 1e-9)


@pytest.mark.parametrize("name", ["systematic", "residual"])
def test_low_variance_schemes_copy_at_least_the_sure_share(name):
    rng = np.random.default_rng(2)
    for _ in range(200):
        weights = rng.random(30) ** 4
        weights /= weights.sum()
        counts = np.bincount(INDEX_DRAWS[name](weights, rng), minlength=30)
        assert (counts >= np.floor(30 * weights - 1e-9)).all()


@pytest.mark.parametrize("name", RESAMPLERS)
def test_output_is_equally_weighted_and_complete(name):
    peak = Peak(np.eye(3))
    particles = cloud(peak)
    result = RESAMPLERS[name](particles, context(peak), np.random.default_rng(3))
    assert result.warps.shape == particles.warps.shape
    np.testing.assert_allclose(result.weights, 0.01)
    assert aff2.is_valid(result.warps).all()


@pytest.mark.parametrize("name", RESAMPLERS)
def test_same_generator_same_particles(name):
    peak = Peak(np.eye(3))
    particles = cloud(peak)
    first = RESAMPLERS[name](particles, context(peak), np.random.default_rng(4))
    again = RESAMPLERS[name](particles, context(peak), np.random.default_rng(4))
    np.testing.assert_array_equal(first.warps, again.warps)


@pytest.mark.parametrize("name", ["multinomial", "systematic", "residual"])
def test_a_single_heavy_particle_takes_all(name):
    peak = Peak(np.eye(3), sharpness=1e6)
    particles = cloud(peak)
    result = RESAMPLERS[name](particles, context(peak), np.random.default_rng(5))
    heavy = particles.warps[np.argmax(particles.log_weights)]
    np.testing.assert_array_equal(result.warps, np.tile(heavy, (100, 1, 1)))


@pytest.mark.parametrize(
    "reading",
    [
        {},
        {"direction": "away-from-low"},
        {"direction": "from-low"},
        {"low": "below-average"},
        {"centre": "best"},
        {"dimension": 3, "step_gain": 1.0},
    ],
)
def test_improved_gaussian_never_falls_below_the_parent(reading):
    peak = Peak(np.eye(3))
    particles = cloud(peak)
    result = RESAMPLERS["improved-gaussian"](
        particles, context(peak, **reading), np.random.default_rng(6)
    )
    parents = np.sort(particles.log_likelihoods)
    assert result.log_likelihoods.min() >= parents[0]
    np.testing.assert_allclose(result.log_likelihoods, peak.log_likelihood(result.warps), atol=1e-9)
    plain = RESAMPLERS["multinomial"](particles, context(peak), np.random.default_rng(6))
    assert (result.log_likelihoods >= plain.log_likelihoods - 1e-12).all()


def test_improved_gaussian_keeps_more_distinct_particles_than_copies():
    peak = Peak(np.eye(3), sharpness=200.0)
    particles = cloud(peak)
    improved = RESAMPLERS["improved-gaussian"](particles, context(peak), np.random.default_rng(7))
    plain = RESAMPLERS["residual"](particles, context(peak), np.random.default_rng(7))
    assert len(np.unique(improved.warps[:, 0, 2])) > len(np.unique(plain.warps[:, 0, 2]))


def test_improved_gaussian_falls_back_to_the_parent_when_nothing_is_better():
    class OnlyParents(Peak):
        def log_likelihood(self, warps):
            return np.full(len(warps), -1e9)

    peak = Peak(np.eye(3))
    particles = cloud(peak)
    result = RESAMPLERS["improved-gaussian"](
        particles, context(OnlyParents(np.eye(3))), np.random.default_rng(8)
    )
    plain = RESAMPLERS["multinomial"](particles, context(peak), np.random.default_rng(8))
    np.testing.assert_array_equal(result.warps, plain.warps)


def test_improved_gaussian_survives_particles_without_a_logarithm():
    peak = Peak(np.eye(3))
    particles = cloud(peak)
    warps = particles.warps.copy()
    warps[5] = np.diag([-2.0, -3.0, 1.0])
    weights = particles.log_weights.copy()
    weights[5] = -np.inf
    result = RESAMPLERS["improved-gaussian"](
        Particles(warps, particles.previous, weights, particles.log_likelihoods),
        context(peak),
        np.random.default_rng(9),
    )
    assert aff2.is_valid(result.warps).all()
    assert np.isfinite(aff2.log(result.warps)).all()


class Everywhere(Peak):
    """Likes every warp better than a parent, so that the first trial is taken."""

    def log_likelihood(self, warps):
        return np.full(len(warps), 1e9)


@pytest.mark.parametrize(
    ("reading", "moved"),
    [
        ({}, 0.5 * 100 ** (-1 / 6)),
        ({"dimension": 3}, 0.5 * 100 ** (-1 / 3)),
        ({"step_gain": 1.0}, 100 ** (-1 / 6)),
        ({"direction": "away-from-low"}, -0.5 * 100 ** (-1 / 6)),
        ({"direction": "from-low"}, 1 - 0.5 * 100 ** (-1 / 6)),
    ],
)
def test_the_first_trial_lies_on_the_line_to_a_low_particle(reading, moved):
    """One heavy particle at the identity, all low ones at x = 1, no spread: Eqs (24), (25)."""
    low = np.tile(aff2.exp(np.array([0, 0, 0, 0, 1.0, 0])), (99, 1, 1))
    warps = np.concatenate([np.eye(3)[None], low])
    log_weights = np.where(np.arange(100) == 0, 0.0, -np.inf)
    particles = Particles(warps, warps.copy(), log_weights, np.zeros(100))
    given = make_context(Everywhere(np.eye(3)), np.zeros((6, 6)), CombinationConfig(**reading))
    result = RESAMPLERS["improved-gaussian"](particles, given, np.random.default_rng(0))
    np.testing.assert_allclose(result.warps[:, 0, 2], moved, atol=1e-12)


@pytest.mark.parametrize(("spread", "variance"), [("estimate", 1e-3), ("prediction", 5e-3)])
def test_the_patent_spreads_all_around_the_best_particle(spread, variance):
    peak = Peak(aff2.exp(np.array([0, 0, 0, 0, 0.1, 0.1])))
    particles = cloud(peak, spread=0.5)
    everywhere = Everywhere(np.eye(3))
    result = RESAMPLERS["improved-gaussian"](
        particles,
        context(everywhere, centre="best", step_gain=0.0, spread=spread),
        np.random.default_rng(1),
    )
    best = particles.warps[np.argmax(particles.log_weights)]
    error = aff2.difference(best, result.warps)
    np.testing.assert_allclose(error.std(axis=0), np.sqrt(variance), rtol=0.3)


def test_low_particles_of_the_patent_are_those_below_the_average_weight():
    """All heavy ones are drawn or not; only the two light ones may pull."""
    warps = np.tile(np.eye(3), (10, 1, 1))
    warps[:2, 0, 2] = 5.0
    weights = np.array([1e-9] * 2 + [1.0] * 8)
    log_weights = np.log(weights / weights.sum())
    particles = Particles(warps, warps.copy(), log_weights, np.zeros(10))
    given = make_context(
        Everywhere(np.eye(3)), np.zeros((6, 6)), CombinationConfig(low="below-average")
    )
    result = RESAMPLERS["improved-gaussian"](particles, given, np.random.default_rng(0))
    np.testing.assert_allclose(result.warps[:, 0, 2], 5.0 * 0.5 * 10 ** (-1 / 6))


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("step_gain", -1.0),
        ("dimension", 0),
        ("max_halvings", -1),
        ("direction", "sideways"),
        ("low", "all"),
        ("centre", "worst"),
        ("spread", "none"),
    ],
)
def test_a_bad_reading_is_refused(field, value):
    with pytest.raises(ValueError, match=field):
        CombinationConfig(**{field: value})
