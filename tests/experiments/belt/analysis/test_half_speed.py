"""The half-success speed on data whose answer is known."""

import math

import numpy as np
import pytest
from toy_trial import trials_of

from experiments.belt.analysis.half_speed import crossing, half_speed, half_speed_table
from experiments.belt.config import TrialConfig
from experiments.belt.presets import expand

SPEEDS = [0.2, 0.4, 0.6, 0.8, 1.0]


@pytest.fixture
def sweep(make_row):
    """Rows of a tracker that succeeds where `decide(speed, seed)` says so."""

    def make(decide, seed_count, speeds=SPEEDS):
        trials = trials_of(expand(speed_mps=speeds), range(seed_count))
        return [make_row(c, success=bool(decide(c.speed_mps, c.seed))) for c in trials]

    return make


@pytest.mark.parametrize(
    ("successes", "expected"),
    [
        ([10, 10, 10, 0, 0], 0.7),
        ([10, 10, 6, 2, 0], 0.65),
        ([10, 8, 8, 5, 0], 0.8),
        ([10, 6, 8, 3, 3], 0.7),  # 6 and 8 pool to 7
        ([10, 10, 10, 10, 9], math.inf),
        ([4, 0, 0, 0, 0], -math.inf),
        ([1, 9, 10, 10, 10], math.inf),  # all pool to 8
    ],
)
def test_the_crossing_by_hand(successes, expected):
    found = crossing(np.array(SPEEDS), np.array(successes), np.full(5, 10))
    assert found == pytest.approx(expected)


def test_speeds_without_trials_tell_nothing():
    found = crossing(np.array(SPEEDS), np.array([9, 0, 0, 1, 0]), np.array([10, 0, 0, 10, 10]))
    assert found == pytest.approx(0.2 + 0.5 * 0.6)


def test_intervals_hold_the_truth_of_a_logistic_curve(sweep, monkeypatch):
    """Half speed 0.63: nineteen of twenty intervals should hold it.

    Linear interpolation between speeds of 0.2 m/s is off by less than 0.02 m/s here.
    """
    monkeypatch.setattr("experiments.belt.analysis.half_speed._RESAMPLES", 500)
    truth, holds, speeds = 0.63, 0, []
    for repeat in range(20):
        rng = np.random.default_rng(repeat)
        draws = rng.random((30, len(SPEEDS)))
        found = half_speed(
            sweep(
                lambda speed, seed, draws=draws: (
                    draws[seed, SPEEDS.index(speed)] < 1 / (1 + math.exp(12 * (speed - truth)))
                ),
                30,
            ),
            rng,
        )
        speeds.append(found.speed_mps)
        holds += found.low_mps <= truth <= found.high_mps
        assert found.low_mps <= found.speed_mps <= found.high_mps
    assert holds >= 16
    assert np.median(speeds) == pytest.approx(truth, abs=0.02)


def test_a_seed_is_drawn_with_all_its_speeds(sweep):
    """Half of the worlds can be grasped at any speed: every resample has one rate for all."""
    found = half_speed(sweep(lambda speed, seed: seed < 10, 20), np.random.default_rng(0))
    assert (found.low_mps, found.high_mps) == (-math.inf, math.inf)


def test_the_table_says_on_which_side_of_the_tested_speeds_it_lies(sweep, make_row):
    rows = sweep(lambda speed, seed: True, 5)
    table = half_speed_table(rows)
    assert "> 1.00 [> 1.00, > 1.00]" in table.to_markdown()
    assert table.rows[0]["n"] == 25 and table.rows[0]["seed_count"] == 5
    never = half_speed_table(sweep(lambda speed, seed: False, 5))
    assert "< 0.20 [< 0.20, < 0.20]" in never.to_markdown()
    assert not half_speed_table(sweep(lambda speed, seed: True, 5, SPEEDS[:2])).rows
    assert not half_speed_table([make_row(TrialConfig())]).rows
