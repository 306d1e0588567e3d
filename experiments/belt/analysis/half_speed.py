"""The belt speed up to which a tracker grasps half of the objects, and how sure that is.

Success falls with speed, in which shape nobody knows: it may hold and then break off at the reach
of the arm. So the rates are fitted by the nearest falling ones, not by a logistic curve, and read
off where they pass one half, as one reads an ED50 off a dose-response experiment.

Sources:
    [Ayer1955] isotonic maximum likelihood of binomial rates (pooling of adjacent violators).
    [Stylianou2002] the dose of a given response by linear interpolation between its values.
    [Efron1987] BCa interval; seeds are drawn, since a seed gives all speeds its world.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import isotonic_regression

from experiments.belt.analysis.cells import condition_keys, key_columns
from experiments.belt.config import TrialResult
from experiments.report.grouping import named_groups
from experiments.report.statistics import bootstrap
from experiments.report.table import Column, Table, TableRow, word, words
from experiments.seeding import Stream, generator

FEWEST_SPEEDS = 3
"""With fewer there is no curve to read from."""

_RESAMPLES = 2000


@dataclass(frozen=True)
class HalfSpeed:
    """A speed with its 95 % interval [m/s]; -inf below and +inf above the tested speeds."""

    speed_mps: float
    low_mps: float
    high_mps: float


def half_speed(results: Sequence[TrialResult], rng: np.random.Generator) -> HalfSpeed:
    """Returns the half-success speed of the trials of one tracker in one setting.

    Args:
        results: Trials at two speeds or more, each seed at most once a speed.
        rng: Draws the seeds of the bootstrap.
    """
    speeds = sorted({row.speed_mps for row in results})
    seeds = sorted({row.seed for row in results})
    tried, succeeded = np.zeros((2, len(seeds), len(speeds)))
    for row in results:
        place = seeds.index(row.seed), speeds.index(row.speed_mps)
        tried[place] += 1.0
        succeeded[place] += row.success

    def of_seeds(drawn: np.ndarray) -> float:
        places = drawn.astype(int)
        return crossing(np.array(speeds), succeeded[places].sum(axis=0), tried[places].sum(axis=0))

    # To be sorted and averaged, a place beyond the tested speeds is one step beyond them.
    below, above = 2.0 * speeds[0] - speeds[1], 2.0 * speeds[-1] - speeds[-2]

    def statistic(drawn: np.ndarray, axis: int = -1) -> np.ndarray:
        return np.clip(np.apply_along_axis(of_seeds, axis, drawn), below, above)

    found = bootstrap(statistic, rng, np.arange(len(seeds)), draws=_RESAMPLES)
    return HalfSpeed(*(_or_infinite(speed_mps, speeds) for speed_mps in found))


def _or_infinite(speed_mps: float, speeds_mps: Sequence[float]) -> float:
    if speed_mps < speeds_mps[0]:
        return -math.inf
    return math.inf if speed_mps > speeds_mps[-1] else speed_mps


def crossing(speeds_mps: np.ndarray, successes: np.ndarray, trials: np.ndarray) -> float:
    """Returns where the nearest falling success rates pass one half.

    Args:
        speeds_mps: (n,) rising.
        successes: (n,) counts.
        trials: (n,) counts; speeds without trials say nothing.

    Returns:
        The speed [m/s]; -inf where all rates are below one half, +inf where none is.
    """
    known = trials > 0
    speeds, n = speeds_mps[known], trials[known]
    rates = _fitted(successes[known] / n, n)
    below = np.flatnonzero(rates < 0.5 - 1e-9)
    if len(below) == 0:
        return math.inf
    if below[0] == 0:
        return -math.inf
    i, j = below[0] - 1, below[0]
    share = (rates[i] - 0.5) / (rates[i] - rates[j])
    return float(speeds[i] + share * (speeds[j] - speeds[i]))


def _fitted(rates: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Returns the nearest falling rates; SciPy comes without types."""
    fit: Any = isotonic_regression(rates, weights=weights, increasing=False)
    return fit.x


def half_speed_table(results: Sequence[TrialResult]) -> Table:
    """Returns the half-success speed of each tracker in each setting with enough speeds."""
    keys = condition_keys(results)
    rows: list[TableRow] = []
    for names, members in named_groups(results, keys):
        speeds = sorted({row.speed_mps for row in members})
        if len(speeds) < FEWEST_SPEEDS:
            continue
        cell = ",".join(map(str, names.values()))
        found = half_speed(members, generator(0, Stream.BOOTSTRAP, cell))
        rows.append(
            names
            | {"n": len(members), "seed_count": len({row.seed for row in members})}
            | {"slowest_mps": speeds[0], "fastest_mps": speeds[-1]}
            | {"half_speed_mps": found.speed_mps}
            | {"half_speed_low_mps": found.low_mps, "half_speed_high_mps": found.high_mps}
        )
    speed = Column("50 % speed [m/s] [95 %]", _show_speed)
    return Table(rows, [*key_columns(keys), *words("n"), word("seeds", "seed_count"), speed])


def _show_speed(row: TableRow) -> str:
    names = ("half_speed_mps", "half_speed_low_mps", "half_speed_high_mps")
    speed, low, high = (_within(row[name], row) for name in names)
    return f"{speed} [{low}, {high}]"


def _within(speed_mps: float, row: TableRow) -> str:
    """Shows the speed, or on which side of the tested ones it lies."""
    if math.isinf(speed_mps):
        return f"> {row['fastest_mps']:.2f}" if speed_mps > 0 else f"< {row['slowest_mps']:.2f}"
    return f"{speed_mps:.2f}"
