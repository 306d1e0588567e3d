import numpy as np
import pytest

from tracker.affine import aff2
from tracker.affine.gauss_newton import climb

TOP = aff2.similarity(20.0, 0.3, np.array([50.0, 40.0]))


class Hill:
    """A log-likelihood that is quadratic around TOP, and flat along some directions."""

    def __init__(self, information):
        self._information = np.diag(information).astype(float)

    def linearise(self, warps, iteration=0):
        del iteration
        away = aff2.difference(TOP, warps)
        return -away @ self._information, np.tile(self._information, (len(warps), 1, 1))


def test_it_ends_at_the_top():
    starts = aff2.perturb(TOP, 0.1 * np.random.default_rng(0).standard_normal((20, 6)))
    ends = climb(Hill([1e4] * 6), starts, 6)
    np.testing.assert_allclose(aff2.difference(TOP, ends), 0.0, atol=1e-6)


def test_what_the_image_does_not_tell_stays():
    start = aff2.perturb(TOP, np.array([0, 0, 0, 0, 0.1, 0.1]))
    end = aff2.difference(TOP, climb(Hill([1e4] * 5 + [0.0]), start[None], 8)[0])
    np.testing.assert_allclose(end, [0, 0, 0, 0, 0, 0.1], atol=1e-3)


def test_no_step_is_long():
    start = aff2.perturb(TOP, np.array([0, 0, 0, 0, 5.0, 0]))
    end = climb(Hill([1e4] * 6), start[None], 1)[0]
    assert aff2.difference(TOP, end)[4] == pytest.approx(4.7, abs=1e-6)
