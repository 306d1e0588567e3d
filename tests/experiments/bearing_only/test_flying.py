"""Single short flights: scores, pairing, oracles, and what goes wrong."""

from dataclasses import replace

import numpy as np
import pytest

from experiments.bearing_only import flying
from experiments.bearing_only.config import FlightRun
from experiments.bearing_only.controllers import CONTROLLERS
from experiments.bearing_only.flying import fly
from experiments.bearing_only.run import results_of
from experiments.bearing_only.studies import STUDIES, world_of

SHORT = FlightRun("circle", "gradient", seed=1000, landmark_count=60, iteration_count=40)


def score(run):
    return results_of([run], fly([run]), "")[0]


@pytest.mark.parametrize("name", CONTROLLERS)
def test_every_controller_flies(name):
    result = score(replace(SHORT, controller=name, iteration_count=15))
    assert result.outcome == "tracked"
    assert result.target_error_m is not None and result.target_error_m < 8.0


@pytest.mark.parametrize("name", STUDIES)
def test_every_study_flies(name):
    run = replace(STUDIES[name].base, seed=1000, iteration_count=15, landmark_count=40)
    assert score(run).outcome == "tracked"


def test_the_same_run_gives_the_same_row():
    assert score(SHORT) == score(SHORT)


def test_slam_is_better_than_dead_reckoning_over_a_flight():
    run = replace(SHORT, iteration_count=250)
    result = score(run)
    assert result.outcome == "tracked"
    assert result.robot_error_m < result.dead_reckoning_error_m
    assert result.landmarks_in_view > 5


def test_moving_aside_is_worth_more_than_following():
    runs = [
        replace(SHORT, controller=name, seed=seed, iteration_count=200)
        for name in ("known-pose", "follow")
        for seed in (1000, 1001)
    ]
    errors = {run.controller: [] for run in runs}
    for run in runs:
        errors[run.controller].append(score(run).target_error_late_m)
    assert np.mean(errors["follow"]) > 2.0 * np.mean(errors["known-pose"])


def test_oracles_fly_together_as_they_fly_alone():
    runs = [replace(SHORT, controller="known-pose", seed=seed) for seed in (1000, 1001)]
    together = results_of(runs, fly(runs), "")
    for run, row in zip(runs, together, strict=True):
        assert np.isclose(row.target_error_m, score(run).target_error_m)
    assert together[0].robot_error_m == 0.0
    assert together[0].robot_nees is None


def test_noise_that_the_filter_knows_of_hurts_less():
    base = FlightRun("localisation", "known-pose", landmark_count=0, iteration_count=200)
    errors = {}
    for kind in ("none", "told", "hidden"):
        runs = [replace(base, seed=s, pose_error=kind, pose_error_m=0.5) for s in range(1000, 1010)]
        rows = results_of(runs, fly(runs), "")
        errors[kind] = np.mean([row.target_error_m for row in rows])
    assert errors["none"] < errors["told"] < errors["hidden"]


def test_without_landmarks_the_pose_is_that_of_the_odometry():
    result = score(replace(SHORT, landmark_count=0))
    assert np.isclose(result.robot_error_m, result.dead_reckoning_error_m)


def test_a_target_that_leaves_the_view_for_good_is_lost_and_its_row_is_kept(monkeypatch):
    class Leaving(flying.Flight):
        def look(self):
            sight = super().look()
            return replace(sight, is_target_seen=sight.is_target_seen & (self.iteration < 20))

    monkeypatch.setattr(flying, "Flight", Leaving)
    result = score(replace(SHORT, iteration_count=100))
    assert result.outcome == "lost"
    assert result.target_error_m is not None
    assert result.seen_share == 0.2


def test_a_target_that_is_never_seen_is_a_row_too(monkeypatch):
    class Blind(flying.Flight):
        def look(self):
            return replace(super().look(), is_target_seen=np.zeros((), bool))

    monkeypatch.setattr(flying, "Flight", Blind)
    result = score(replace(SHORT, iteration_count=5))
    assert (result.outcome, result.detail) == ("lost", "the target was never seen")


def test_a_measurement_that_is_no_number_breaks_the_flight_off_with_its_reason(monkeypatch):
    class Faulty(flying.Flight):
        def look(self):
            sight = super().look()
            if self.iteration == 7:
                sight.target_px[0] = np.nan
            return sight

    monkeypatch.setattr(flying, "Flight", Faulty)
    result = score(SHORT)
    assert result.outcome == "error"
    assert result.detail == "ValueError: target_px must be finite numbers, got nan"
    assert result.target_error_m is None


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"controller": "gradeint"}, "did you mean 'gradient'"),
        ({"v_max_mps": float("nan")}, "v_max_mps must be a positive number, got nan"),
        ({"target_speed_mps": -1.0}, "target_speed_mps must be a positive number, got -1.0"),
        ({"landmark_count": -3}, "landmark_count must be 0 or greater, got -3"),
        ({"pose_error_m": float("inf")}, "pose_error_m must be 0 or greater, got inf"),
        ({"study": "square"}, "study must be one of line, circle, speed, localisation, robot"),
    ],
)
def test_impossible_runs_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        replace(SHORT, **change)


def test_the_head_on_target_comes_head_on():
    config = world_of(STUDIES["line"].base)
    assert config.target.at(0.0)[1][1] == -2.0
    assert config.start_m[0] == config.target.start_m[0]
