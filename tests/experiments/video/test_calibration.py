import numpy as np
import pytest
import scipy.stats

from experiments.video.calibration import NEES_MEDIAN, calibrated


def test_the_median_is_that_of_the_distribution():
    assert pytest.approx(scipy.stats.chi2.median(6), abs=5e-4) == NEES_MEDIAN


def test_each_half_gets_the_factor_of_the_other():
    nees = {"A": [2 * NEES_MEDIAN], "B": [NEES_MEDIAN, 4 * NEES_MEDIAN, 9.0 * NEES_MEDIAN]}
    expected = [2 / 4, 1 / 2, 4 / 2, 9 / 2]
    np.testing.assert_allclose(calibrated(nees), np.array(expected) * NEES_MEDIAN)


def test_a_factor_common_to_all_sequences_drops_out():
    rng = np.random.default_rng(0)
    nees = {name: 7.0 * rng.chisquare(6, 400) for name in "ABCDEF"}
    assert calibrated(nees).mean() == pytest.approx(6.0, rel=0.05)


@pytest.mark.parametrize("nees", [{}, {"A": [1.0]}, {"A": [1.0], "B": []}, {"A": [0.0], "B": [1]}])
def test_nothing_to_calibrate_with_gives_nothing(nees):
    assert len(calibrated(nees)) == 0
