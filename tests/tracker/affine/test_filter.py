from dataclasses import asdict, replace

import numpy as np
import pytest

from tracker.affine import aff2
from tracker.affine.filter import METHODS, FilterConfig, ParticleFilter
from tracker.affine.resampling import Particles
from tracker.belt.registry import TRACKERS
from tracker.video.registry import BOX_TRACKERS

PARTS = {
    "igpf": ("group", "gaussian", "improved-gaussian"),
    "gpf": ("group", "gaussian", "residual"),
    "pf": ("vector", "prior", "systematic"),
}


class Indifferent:
    """An image that says nothing."""

    def log_likelihood(self, warps):
        return np.zeros(len(warps))

    def linearise(self, warps, iteration=0):
        return np.zeros((len(warps), 6)), np.zeros((len(warps), 6, 6))


class Impossible(Indifferent):
    """An image that no warp explains."""

    def log_likelihood(self, warps):
        return np.full(len(warps), -np.inf)


@pytest.fixture(params=["igpf", "gpf", "pf"])
def config(request):
    from tracker.belt.registry import get_tracker_config

    return get_tracker_config(request.param).filter


def started(config, seed=0):
    particle_filter = ParticleFilter(config, np.random.default_rng(seed))
    particle_filter.start(aff2.similarity(40.0, 0.5, [100, 50]))
    return particle_filter


def test_same_seed_same_path(config):
    paths = []
    for _ in range(2):
        particle_filter = started(config, seed=5)
        paths.append([particle_filter.step(Indifferent(), 1 / 30).warp for _ in range(3)])
    np.testing.assert_array_equal(paths[0], paths[1])


def test_non_finite_particles_get_no_weight_and_disappear(config):
    particle_filter = started(config)
    good = particle_filter.particles
    warps = good.warps.copy()
    warps[3] = np.nan
    warps[7, :2, :2] = -1e30
    warps[9] = np.diag([-2.0, -3.0, 1.0])
    particles = Particles(warps, good.previous, good.log_weights, good.log_likelihoods)
    particle_filter._state = replace(particle_filter._state, particles=particles)
    estimate = particle_filter.step(Indifferent(), 1 / 30)
    assert np.isfinite(estimate.warp).all()
    assert np.isfinite(estimate.covariance).all()
    assert aff2.is_valid(particle_filter.particles.warps).all()


def test_an_inexplicable_image_leaves_finite_particles(config):
    particle_filter = started(config)
    estimate = particle_filter.step(Impossible(), 1 / 30)
    assert estimate.log_likelihood == -np.inf
    assert np.isfinite(estimate.warp).all()
    assert np.isfinite(particle_filter.step(Indifferent(), 1 / 30).warp).all()


def test_coasting_keeps_the_velocity():
    config = FilterConfig(autoregression=1.0, noise_per_root_s=(1e-6,) * 6)
    particle_filter = ParticleFilter(config, np.random.default_rng(0))
    start, then = (aff2.similarity(40.0, 0.0, [x, 50]) for x in (100.0, 110.0))
    particle_filter.start(then, start, 1 / 30)
    for _ in range(3):
        estimate = particle_filter.step(None, 1 / 30)
    np.testing.assert_allclose(estimate.warp[0, 2], 140.0, atol=0.1)


def test_without_an_image_weights_stay_and_nothing_is_resampled(config):
    particle_filter = started(config)
    resamplings = []
    particle_filter.collector = lambda *pair: resamplings.append(pair)
    before = particle_filter.particles
    estimate = particle_filter.step(None, 1 / 30)
    after = particle_filter.particles
    assert estimate.log_likelihood == -np.inf and not resamplings
    np.testing.assert_array_equal(after.log_weights, before.log_weights)
    np.testing.assert_array_equal(after.previous, before.warps)
    assert (np.abs(after.warps - before.warps).max(axis=(1, 2)) > 0).all()
    particle_filter.step(Indifferent(), 1 / 30)
    assert len(resamplings) == 1


def test_a_detection_moves_as_many_particles_as_there_are_places(config):
    particle_filter = started(replace(config, noise_per_root_s=(1e-9,) * 6))
    places = np.array([[500.0, 400.0], [500.0, 400.0], [500.0, 400.0]])
    collected = []
    particle_filter.collector = lambda before, after: collected.append(before.warps)
    particle_filter.step(Indifferent(), 1 / 30, places)
    is_there = np.linalg.norm(collected[0][:, :2, 2] - places[0], axis=1) < 1.0
    assert is_there.sum() == 3


def test_particles_before_start_are_refused():
    with pytest.raises(ValueError, match="start"):
        _ = ParticleFilter(FilterConfig(), np.random.default_rng(0)).particles


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("particle_count", 0),
        ("state_space", "sphere"),
        ("proposal", "oracle"),
        ("resampling", "none"),
        ("autoregression", np.nan),
        ("noise_per_root_s", (0.1, 0.1, 0.1, 0.1, 0.1, -0.1)),
        ("noise_per_root_s", (0.1,)),
        ("iterations", 0),
        ("prior_share", 1.0),
        ("resampling_threshold", 1.5),
    ],
)
def test_bad_settings_are_refused(field, value):
    with pytest.raises(ValueError, match=field):
        FilterConfig(**{field: value})


def test_gaussian_proposal_on_a_vector_is_refused():
    with pytest.raises(ValueError, match="proposal"):
        FilterConfig(state_space="vector", proposal="gaussian")


@pytest.mark.parametrize("name", METHODS)
def test_a_method_sets_its_own_parts_and_no_other(name):
    before = FilterConfig(particle_count=33, autoregression=0.25)
    after = METHODS[name].applied_to(before)
    changed = {field for field, value in asdict(after).items() if value != asdict(before)[field]}
    assert changed <= {"state_space", "proposal", "resampling"}
    assert (after.state_space, after.proposal, after.resampling) == PARTS[name]


@pytest.mark.parametrize("table", [TRACKERS, BOX_TRACKERS], ids=["belt", "video"])
@pytest.mark.parametrize("name", METHODS)
def test_rows_of_the_comparison_differ_only_in_what_the_methods_differ_in(table, name):
    row, igpf = table[name], table["igpf"]
    assert row.filter == METHODS[name].applied_to(igpf.filter)
    assert replace(row, filter=igpf.filter, description=igpf.description) == igpf
    assert row.description == METHODS[name].description
