"""Moments of weighted warps on both state spaces."""

import numpy as np
import pytest

from tracker.affine import aff2
from tracker.affine.state_space import STATE_SPACES, moments

CENTRE = np.array([[30.0, 2.0, 100.0], [-1.0, 25.0, 80.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize("space", STATE_SPACES.values(), ids=STATE_SPACES)
def test_moments_of_a_narrow_cloud_are_those_of_its_tangent_vectors(space):
    rng = np.random.default_rng(0)
    spread = np.array([0.02, 0.01, 0.03, 0.01, 0.02, 0.03])
    e = rng.standard_normal((4000, 6)) * spread
    weights = np.full(4000, 1 / 4000)
    warp, covariance = moments(space, space.perturb(np.tile(CENTRE, (4000, 1, 1)), e), weights)
    np.testing.assert_allclose(aff2.difference(CENTRE, warp), 0.0, atol=2e-3)
    np.testing.assert_allclose(np.sqrt(np.diag(covariance))[:4], spread[:4], rtol=0.2)


@pytest.mark.parametrize("space", STATE_SPACES.values(), ids=STATE_SPACES)
def test_a_warp_without_a_logarithm_does_no_harm(space):
    """Half a turn away and sheared: no real logarithm leads there from the others."""
    turned = CENTRE @ np.diag([-1.4, -0.7, 1.0])
    assert np.isnan(aff2.difference(CENTRE, turned)).any()
    warps = np.stack([CENTRE] * 9 + [turned])
    warp, covariance = moments(space, warps, np.full(10, 0.1))
    assert np.isfinite(warp).all() and np.isfinite(covariance).all()
    assert aff2.is_valid(warp)


@pytest.mark.parametrize("space", STATE_SPACES.values(), ids=STATE_SPACES)
def test_advancing_repeats_a_share_of_the_last_motion(space):
    rng = np.random.default_rng(1)
    start = space.perturb(np.tile(CENTRE, (5, 1, 1)), 0.1 * rng.standard_normal((5, 6)))
    e = 0.1 * rng.standard_normal((5, 6))
    end = space.perturb(start, e)
    np.testing.assert_allclose(space.advance(start, end, 0.0), end, atol=1e-9)
    further = space.difference(end, space.advance(start, end, 0.6))
    expected = 0.6 * space.difference(start, end)
    np.testing.assert_allclose(further, expected, atol=1e-9)
