import itertools
import math

import numpy as np
import pytest

from experiments.report.statistics import (
    bootstrap,
    holm,
    mcnemar_exact,
    mean,
    mean_ratio,
    median,
    median_difference,
    newcombe_paired_difference,
    paired_sample_size,
    wilson_interval,
)


@pytest.mark.parametrize(
    ("success_count", "n", "low", "high"),
    [
        # Newcombe, Statistics in Medicine 17:857-872 (1998), table I, method 3.
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
        # By hand: n / (n + z^2).
        (50, 50, 0.9287, 1.0),
    ],
)
def test_wilson_interval_agrees_with_published_values(success_count, n, low, high):
    assert wilson_interval(success_count, n) == pytest.approx((low, high), abs=6e-5)


def test_wilson_interval_solves_its_quadratic():
    for bound in wilson_interval(7, 12):
        z = abs(7 / 12 - bound) / math.sqrt(bound * (1 - bound) / 12)
        assert z == pytest.approx(1.959963984540054)


def test_wilson_interval_without_trials_says_nothing():
    assert wilson_interval(0, 0) == (0.0, 1.0)


def test_wilson_interval_refuses_more_successes_than_trials():
    with pytest.raises(ValueError, match="success_count must be from 0 to n = 3, got 4"):
        wilson_interval(4, 3)


def test_mcnemar_exact_by_hand():
    assert mcnemar_exact(0, 0) == 1.0
    assert mcnemar_exact(1, 7) == pytest.approx(2 * (1 + 8) / 2**8)
    assert mcnemar_exact(7, 1) == mcnemar_exact(1, 7)
    assert mcnemar_exact(5, 5) == 1.0
    assert mcnemar_exact(6, 16) == pytest.approx(0.052479, abs=1e-6)


def test_newcombe_paired_difference_agrees_with_the_published_value():
    # Fagerland, Lydersen, Laake, Statistical Analysis of Contingency Tables (2017), chapter 8.
    expected = (-0.0621, -0.1186, -0.0046)
    assert newcombe_paired_difference(59, 6, 16, 80) == pytest.approx(expected, abs=6e-5)


def test_newcombe_paired_difference_without_correlation_by_hand():
    # 1 x 12 - 1 x 7 = 5 is under n / 2 = 10.5, so the corrected correlation is zero.
    (low1, high1), (low2, high2) = wilson_interval(2, 21), wilson_interval(8, 21)
    difference, low, high = newcombe_paired_difference(1, 1, 7, 12)
    assert difference == pytest.approx(-6 / 21)
    assert low == pytest.approx(difference - math.hypot(2 / 21 - low1, high2 - 8 / 21))
    assert high == pytest.approx(difference + math.hypot(high1 - 2 / 21, 8 / 21 - low2))


def test_newcombe_paired_difference_is_antisymmetric_and_bounded():
    for a, b, c, d in itertools.product((0, 1, 5), repeat=4):
        difference, low, high = newcombe_paired_difference(a, b, c, d)
        assert -1.0 <= low <= difference <= high <= 1.0
        mirrored = newcombe_paired_difference(a, c, b, d)
        assert mirrored == pytest.approx((-difference, -high, -low))


def test_a_bootstrapped_mean_has_the_interval_of_the_normal_law():
    values = np.random.default_rng(1).normal(5.0, 2.0, 400)
    value, low, high = bootstrap(mean, np.random.default_rng(0), values)
    assert value == values.mean()
    half = 1.96 * values.std() / 20.0
    assert (low, high) == pytest.approx((value - half, value + half), abs=0.02)


def test_a_bootstrap_leans_to_the_side_of_the_long_tail():
    """Means of skewed values: BCa reaches further up than down, which percentiles hardly do."""
    values = np.random.default_rng(2).exponential(1.0, 30)
    value, low, high = bootstrap(mean, np.random.default_rng(0), values)
    assert (high - value) > 1.15 * (value - low)


def test_a_ratio_is_that_of_the_means_and_pairs_stay_together():
    rng = np.random.default_rng(0)
    reference = rng.uniform(0.2, 0.6, 30)
    assert bootstrap(mean_ratio, rng, 1.2 * reference, reference) == pytest.approx((1.2,) * 3)
    noisy = reference + rng.normal(0.1, 0.1, 30)
    ratio, low, high = bootstrap(mean_ratio, rng, noisy, reference)
    assert ratio == noisy.mean() / reference.mean()
    deviation = (noisy - reference).std() / np.sqrt(30) / reference.mean()
    assert low < ratio < high
    assert high - low == pytest.approx(2 * 1.96 * deviation, rel=0.25)


def test_the_difference_of_medians_is_that_of_pairs():
    values = np.random.default_rng(0).exponential(1.0, 41)
    shifted = bootstrap(median_difference, np.random.default_rng(0), values + 0.25, values)
    assert shifted == pytest.approx((0.25,) * 3)
    middle, low, high = bootstrap(median, np.random.default_rng(0), values)
    assert middle == np.sort(values)[20] and low < middle < high


@pytest.mark.filterwarnings("error")
def test_where_nothing_varies_the_interval_is_the_value():
    rng = np.random.default_rng(0)
    assert bootstrap(median, rng, [3.5]) == (3.5,) * 3
    assert bootstrap(mean, rng, [0.1] * 7) == (np.mean([0.1] * 7),) * 3
    assert bootstrap(median_difference, rng, [4.0, 1.0], [3.0, 0.0]) == (1.0,) * 3


@pytest.mark.filterwarnings("error")
def test_where_bca_is_undefined_percentiles_stand_in():
    """Dropping one of many equal values never moves their median: no acceleration."""
    values = [1.0] * 9 + [2.0] * 3
    value, low, high = bootstrap(median, np.random.default_rng(0), values)
    assert value == low == 1.0 and high in (1.0, 1.5, 2.0)


def test_a_reference_that_scores_nothing_has_no_ratio():
    ratio, low, high = bootstrap(mean_ratio, np.random.default_rng(0), [0.5, 0.4], [0.0, 0.0])
    assert ratio == np.inf and math.isnan(low) and math.isnan(high)


def test_the_same_generator_gives_the_same_interval():
    values = np.random.default_rng(3).normal(size=20)
    first, second = (bootstrap(mean, np.random.default_rng(0), values) for _ in range(2))
    assert first == second


def test_paired_sample_size_by_hand():
    """Shares .2 and .1: (1.96 sqrt(.3) + .8416 sqrt(.29))^2 / .1^2 = 233.1."""
    assert paired_sample_size(20, 10, 100) == 234
    assert paired_sample_size(10, 20, 100) == 234
    assert paired_sample_size(2, 1, 10) == 234
    assert paired_sample_size(3, 3, 50) is None


def test_paired_sample_size_has_its_power():
    """With that many pairs, about 80 % of experiments reject equality."""
    n = paired_sample_size(20, 10, 100)
    rng = np.random.default_rng(0)
    counts = rng.multinomial(n, [0.2, 0.1, 0.7], size=2000)
    rejected = np.mean([mcnemar_exact(int(b), int(c)) < 0.05 for b, c, _ in counts])
    assert 0.74 < rejected < 0.84


def test_holm_raises_each_p_by_the_number_of_those_not_smaller():
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert holm([0.9, 0.8]) == [1.0, 1.0]
    assert holm([]) == []
