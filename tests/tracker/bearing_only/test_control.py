import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker.bearing_only.control import (
    ControlConfig,
    DifferentialDrive,
    WheelDrive,
    command,
    follow,
    follow_speed,
    manoeuvre_direction,
    range_std,
)
from tracker.bearing_only.measurements import PinholeCamera, PoseBelief, TargetBelief

POSE = PoseBelief(np.zeros(3), np.eye(3), np.zeros((6, 6)))


def target_at(distance, std_along):
    P = np.diag([std_along**2, 0.01, 0.01, 1.0, 1.0, 1.0])
    return TargetBelief(np.array([distance, 0.0, 0.0]), np.zeros(3), P)


@given(st.floats(0.0, 60.0), st.floats(0.05, 1.0))
def test_the_following_speed_is_the_seed_s_sigmoid(distance, steepness):
    """[Wu2022] Eq. 15 as printed, times the time step that it lacks."""
    printed = -2.5 + 2.0 * 2.5 / (1.0 + math.exp(steepness * (10.0 - distance)))
    assert np.isclose(follow_speed(np.array(distance), 2.5, 10.0, steepness), printed)


def test_the_floor_holds_while_the_range_is_uncertain():
    config = ControlConfig(manoeuvre="trace", floor_share=0.5)
    assert follow(config, POSE, target_at(30.0, 6.0)) == 1.25
    assert follow(config, POSE, target_at(30.0, 1.0)) > 2.4
    free = ControlConfig(manoeuvre="trace", floor_share=1.0)
    assert follow(free, POSE, target_at(30.0, 6.0)) > 2.4
    pure = ControlConfig(manoeuvre="none", floor_share=0.5)
    assert follow(pure, POSE, target_at(30.0, 6.0)) > 2.4


def test_distance_and_its_deviation_along_the_line_of_sight():
    assert np.allclose(range_std(POSE, target_at(12.0, 3.0)), (12.0, 3.0))


@given(st.floats(-2.5, 2.5), st.integers(0, 1000))
def test_the_manoeuvre_takes_the_speed_that_following_leaves(speed, seed):
    """[Wu2022] Eq. 14 with its norms and its time step."""
    direction = np.random.default_rng(seed).normal(size=3)
    direction /= np.linalg.norm(direction)
    motion = command(
        ControlConfig(manoeuvre="trace"), 0.05, np.array(speed), direction, np.zeros(3)
    )
    assert np.isclose(np.linalg.norm(motion.observability_mps), 2.5 - abs(speed))
    length = np.linalg.norm(motion.increment.displacement_m)
    assert np.isclose(length, 0.125) or np.isclose(length, 0.0)


def test_pure_following_stands_still_at_the_equilibrium():
    config = ControlConfig(manoeuvre="none")
    motion = command(config, 0.05, follow(config, POSE, target_at(10.0, 1.0)), np.zeros(3),
                     np.zeros(3))  # fmt: skip
    assert np.allclose(motion.increment.displacement_m, 0.0)


@pytest.mark.parametrize("kind", ["random", "trace"])
def test_the_saddle_is_left_across_the_line_of_sight(kind):
    normal = np.array([3.0, 1.0, -2.0])
    target = target_at(10.0, 2.0)
    direction = manoeuvre_direction(kind, PinholeCamera(), POSE, target, 3.0, normal)
    assert np.isclose(np.linalg.norm(direction), 1.0)
    assert direction[1] > 0.0 > direction[2]


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_an_impossible_speed_is_refused(value):
    with pytest.raises(ValueError, match=f"v_max_mps must be a positive number, got {value!r}"):
        ControlConfig(v_max_mps=value)


AHEAD = np.array([1.0, 0.0, 0.0])


def wheels():
    return WheelDrive(DifferentialDrive(max_turn_rate_radps=10.0, lean_rad=0.3))


def test_straight_ahead_is_driven_as_wanted():
    step = wheels().convert(np.array([0.2, 0.0, 0.1]), AHEAD, 0.1)
    assert np.allclose(step.displacement_m, [0.02, 0.0, 0.0])
    assert np.allclose(step.rotation_rad, 0.0)


def test_a_wish_to_the_left_leans_as_far_as_the_target_stays_in_view():
    step = wheels().convert(np.array([0.0, 0.2, 0.0]), AHEAD, 0.1)
    assert np.allclose(step.rotation_rad, [0.0, 0.0, 0.3])
    assert np.allclose(step.displacement_m, [0.02, 0.0, 0.0])


def test_backing_off_to_the_left_leans_to_the_right():
    step = wheels().convert(np.array([-0.1, 0.2, 0.0]), AHEAD, 0.1)
    assert step.displacement_m[0] < 0.0
    assert np.isclose(step.rotation_rad[2], -0.3)


def test_the_sense_changes_only_beyond_the_gap():
    drive = wheels()
    drive.convert(np.array([0.2, 0.0, 0.0]), AHEAD, 0.1)
    within = drive.convert(np.array([-0.01, 0.2, 0.0]), AHEAD, 0.1)
    beyond = drive.convert(np.array([-0.1, 0.2, 0.0]), AHEAD, 0.1)
    assert within.displacement_m[0] > 0.0 > beyond.displacement_m[0]


def test_the_turn_is_limited_and_never_sideways():
    drive = WheelDrive(DifferentialDrive(max_turn_rate_radps=1.0))
    rng = np.random.default_rng(0)
    for _ in range(50):
        ray = np.array([1.0, *rng.normal(0.0, 1.0, 2)])
        step = drive.convert(rng.normal(0.0, 0.2, 3), ray, 0.1)
        assert np.all(step.displacement_m[1:] == 0.0)
        assert abs(step.rotation_rad[2]) <= 0.1 + 1e-12
