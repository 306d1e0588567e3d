"""Intervals and tests for success rates and scores; trackers meet the same worlds: paired.

Sources (95 % two-sided unless stated):
    [Wilson1927] E. B. Wilson, Probable inference, the law of succession, and statistical
        inference. JASA 22:209-212, 1927.
    [McNemar1947] Q. McNemar, Note on the sampling error of the difference between correlated
        proportions or percentages. Psychometrika 12:153-157, 1947; exact conditional form.
    [Newcombe1998] R. G. Newcombe, Improved confidence intervals for the difference between
        binomial proportions based on paired data. Statistics in Medicine 17:2635-2650, 1998;
        method 10.
    [Holm1979] S. Holm, A simple sequentially rejective multiple test procedure. Scandinavian
        Journal of Statistics 6:65-70, 1979.
    [Connor1987] R. J. Connor, Sample size for testing differences in proportions for the
        paired-sample design. Biometrics 43:207-211, 1987.
    [Efron1987] B. Efron, Better bootstrap confidence intervals. JASA 82:171-185, 1987; BCa.
"""

import math
import warnings
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from scipy import stats

BOOTSTRAP_SAMPLES = 10_000

SIGNIFICANCE = 0.05
"""Below this p a test decides."""

Z_95 = 1.959963984540054
"""Standard normal quantile of 0.975."""

Z_POWER_80 = 0.8416212335729143
"""Standard normal quantile of 0.8."""


def of_known(
    function: Callable[[list[float]], Any], values: Iterable[float | None], factor: float = 1.0
) -> float | None:
    """Returns `function` of the values that exist, times `factor`; None where none does."""
    known = [value for value in values if value is not None]
    return factor * float(function(known)) if known else None


def wilson_interval(success_count: int, n: int) -> tuple[float, float]:
    """Returns the score interval of a proportion; (0, 1) without trials.  Source: [Wilson1927]."""
    if not 0 <= success_count <= n:
        raise ValueError(f"success_count must be from 0 to n = {n}, got {success_count}")
    if n == 0:
        return 0.0, 1.0
    found: Any = stats.binomtest(success_count, n).proportion_ci(method="wilson")
    return float(found.low), float(found.high)


def mcnemar_exact(first_only: int, second_only: int) -> float:
    """Returns the two-sided p-value that two paired methods succeed equally often.

    Args:
        first_only: Pairs in which only the first method succeeded.
        second_only: Pairs in which only the second method succeeded.

    Source: [McNemar1947], with the exact binomial distribution of the discordant pairs.
    """
    n = first_only + second_only
    return float(stats.binomtest(first_only, n).pvalue) if n else 1.0


def newcombe_paired_difference(
    both: int, first_only: int, second_only: int, neither: int
) -> tuple[float, float, float]:
    """Returns the difference of two paired success rates (first less second) and its interval.

    Args:
        both: Pairs in which both methods succeeded.
        first_only: Pairs in which only the first method succeeded.
        second_only: Pairs in which only the second method succeeded.
        neither: Pairs in which both methods failed.

    Source: [Newcombe1998] method 10.
    Returns: (difference, low, high).
    """
    n = both + first_only + second_only + neither
    if n == 0:
        return 0.0, -1.0, 1.0
    p1, p2 = (both + first_only) / n, (both + second_only) / n
    low1, high1 = wilson_interval(both + first_only, n)
    low2, high2 = wilson_interval(both + second_only, n)
    phi = _corrected_phi(both, first_only, second_only, neither)

    def combined(distance1: float, distance2: float) -> float:
        square = distance1**2 - 2 * phi * distance1 * distance2 + distance2**2
        return math.sqrt(max(0.0, square))

    difference = p1 - p2
    low = difference - combined(p1 - low1, high2 - p2)
    high = difference + combined(high1 - p1, p2 - low2)
    return difference, max(-1.0, low), min(1.0, high)


def holm(p_values: Sequence[float]) -> list[float]:
    """Returns p-values of a family of tests, each raised to what it is worth among the others.

    Those below 0.05 are the findings of which, with a probability of 95 %, none is an accident.
    Source: [Holm1979].
    """
    n, largest = len(p_values), 0.0
    adjusted = [0.0] * n
    for rank, i in enumerate(sorted(range(n), key=p_values.__getitem__)):
        largest = max(largest, min(1.0, (n - rank) * p_values[i]))
        adjusted[i] = largest
    return adjusted


def paired_sample_size(first_only: int, second_only: int, n: int) -> int | None:
    """Returns how many pairs show the observed difference with a power of 80 % at the 5 % level.

    Args:
        first_only: Pairs in which only the first method succeeded.
        second_only: Pairs in which only the second method succeeded.
        n: All pairs.

    Source: [Connor1987], with the observed shares of discordant pairs.
    Returns: the number of pairs; None where both are equal, which no number would decide.
    """
    if first_only == second_only:
        return None
    discordant, difference = (first_only + second_only) / n, (first_only - second_only) / n
    root = Z_95 * math.sqrt(discordant)
    root += Z_POWER_80 * math.sqrt(discordant - difference**2)
    return math.ceil(root**2 / difference**2)


def _corrected_phi(a: int, b: int, c: int, d: int) -> float:
    """Returns the continuity-corrected correlation of a 2 x 2 table; 0 for an empty margin."""
    n = a + b + c + d
    margins = (a + b) * (c + d) * (a + c) * (b + d)
    if margins == 0:
        return 0.0
    determinant = a * d - b * c
    if determinant > 0:
        determinant = max(0.0, determinant - n / 2)
    return determinant / math.sqrt(margins)


def mean(values: np.ndarray, axis: int = -1) -> np.ndarray:
    """Returns the mean, to bootstrap."""
    return np.mean(values, axis=axis)


def median(values: np.ndarray, axis: int = -1) -> np.ndarray:
    """Returns the median, to bootstrap."""
    return np.median(values, axis=axis)


def mean_ratio(values: np.ndarray, reference: np.ndarray, axis: int = -1) -> np.ndarray:
    """Returns the mean over that of a reference on the same samples, to bootstrap in pairs."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.mean(values, axis=axis) / np.mean(reference, axis=axis)


def mean_difference(values: np.ndarray, reference: np.ndarray, axis: int = -1) -> np.ndarray:
    """Returns the mean less that of a reference on the same samples, to bootstrap in pairs."""
    return np.mean(values, axis=axis) - np.mean(reference, axis=axis)


def median_difference(values: np.ndarray, reference: np.ndarray, axis: int = -1) -> np.ndarray:
    """Returns the median less that of a reference on the same samples, to bootstrap in pairs."""
    return np.median(values, axis=axis) - np.median(reference, axis=axis)


def bootstrap(
    statistic: Callable[..., Any],
    rng: np.random.Generator,
    *samples: Sequence[float] | np.ndarray,
    draws: int = BOOTSTRAP_SAMPLES,
) -> tuple[float, float, float]:
    """Returns a statistic of n samples and its 95 % interval.

    Args:
        statistic: A function of one array for each of `samples` and the axis that it reduces.
        rng: Draws the samples.
        *samples: (n,) values; several are drawn together, in pairs.
        draws: How often n samples are drawn.

    Source: [Efron1987], bias-corrected and accelerated (BCa). Where it is not defined, because a
    single sample or samples that are all alike say nothing of bias and acceleration, percentiles
    stand in for it, which are the value itself where nothing varies.
    Returns: (value, low, high); NaN bounds where the value is not finite.
    """
    data = tuple(np.asarray(sample) for sample in samples)
    value = float(statistic(*data, axis=-1))
    if not math.isfinite(value):
        return value, math.nan, math.nan
    if all(np.ptp(sample) == 0 for sample in data):
        return value, value, value
    with warnings.catch_warnings(action="ignore"):
        found: Any = stats.bootstrap(
            data, statistic, paired=True, vectorized=True, n_resamples=draws, rng=rng
        )
    low, high = found.confidence_interval
    if np.isnan([low, high]).any():
        low, high = np.percentile(found.bootstrap_distribution, [2.5, 97.5])
    return value, float(low), float(high)
