"""Worlds by seed: where the object starts, and how what carries it moves."""

import math
from dataclasses import astuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.belt.carriers import BELT_CENTRE_X_M, CARRIERS, CENTRE_M, DISC_RADIUS_M, RADIUS_M
from sim.belt.scenario import MOTIONS, ScenarioRange, draw_profile


def draw(motion: str, seed: int):
    return ScenarioRange().draw(motion, 0.2, np.random.default_rng(seed))


def test_seed_decides_the_world():
    first, again, other = (
        (s.start, s.look_alikes, [s.profile(time_s) for time_s in TIMES_S[:400:40]])
        for s in (draw("sine", seed) for seed in (1, 1, 2))
    )
    assert first == again
    assert all(a != b for a, b in zip(first, other, strict=True))


def test_the_same_seed_lays_the_object_alike_whatever_the_belt_does():
    places = {draw(motion, 3).start for motion in ("constant", "stop-and-go")}
    assert len(places) == 1


def test_places_on_the_belt_fill_their_ranges():
    many = [draw("sine", seed) for seed in range(300)]
    offsets = np.array([s.start.x_m for s in many]) - BELT_CENTRE_X_M
    assert offsets.min() < -0.07 and offsets.max() > 0.07 and np.abs(offsets).max() <= 0.08
    yaws = np.array([s.start.yaw_rad for s in many]) - math.pi / 2
    assert yaws.min() < -1.4 and yaws.max() > 1.4 and np.abs(yaws).max() <= math.pi / 2


def test_places_on_the_turntable_lie_all_around_it():
    many = [draw("turntable", seed) for seed in range(300)]
    p = np.array([[s.start.x_m, s.start.y_m] for s in many]) - CENTRE_M
    radii, angles = np.hypot(*p.T), np.arctan2(p[:, 1], p[:, 0])
    assert np.abs(radii - RADIUS_M).max() <= 0.04
    assert np.histogram(angles, bins=6, range=(-math.pi, math.pi))[0].min() > 25
    turns = [
        math.remainder(s.start.yaw_rad - a - math.pi / 2, 2 * math.pi)
        for s, a in zip(many, angles, strict=True)
    ]
    assert np.abs(turns).max() <= math.pi / 2
    assert {s.profile(0.0) for s in many} == {-0.2, 0.2}
    assert radii.max() < DISC_RADIUS_M - 0.07  # even a long object has its middle well on the disc


def test_position_on_the_first_draws_stays_as_published():
    """The published results belong to these worlds."""
    assert astuple(draw("constant", 0).start) == pytest.approx(
        (0.4631658742022192, -0.8417822987607128, 0.12872212178963482), abs=1e-12
    )


TIMES_S = np.linspace(0.0, 16.0, 4001)


BELT_MOTIONS = [name for name, motion in MOTIONS.items() if motion.carrier == "belt"]


@pytest.mark.parametrize("name", BELT_MOTIONS)
@given(speed_mps=st.floats(0.0, 1.5), seed=st.integers(0, 1000))
def test_no_belt_runs_backwards_and_none_faster_than_one_and_a_half(name, speed_mps, seed):
    profile = draw_profile(name, speed_mps, np.random.default_rng(seed))
    speeds = np.array([profile(time_s) for time_s in TIMES_S[::40]])
    assert (speeds >= 0.0).all() and (speeds <= 1.5 * speed_mps + 1e-12).all()


def test_sine_keeps_its_mean():
    profile = draw_profile("sine", 0.4, np.random.default_rng(0))
    speeds = [profile(time_s) for time_s in TIMES_S[:-1]]
    assert np.mean(speeds) == pytest.approx(0.4, rel=1e-6)
    assert (min(speeds), max(speeds)) == pytest.approx((0.2, 0.6), rel=1e-3)


def test_ramp_goes_either_way_and_then_stays():
    assert draw_profile("ramp", 0.2, np.random.default_rng(0))(1.5) == pytest.approx(0.2)
    ends = {round(draw_profile("ramp", 0.2, np.random.default_rng(s))(9.0), 9) for s in range(20)}
    assert ends == {0.1, 0.3}


def test_stop_and_go_by_hand():
    """Up in 0.5 s, on until 1.0 s, down until 1.5 s, still until 1.6 s."""
    rng = np.random.default_rng(7)
    drawn, phase_s = draw_profile("stop-and-go", 0.5, rng), np.random.default_rng(7).uniform(0, 1.6)
    by_hand = {0.0: 0.0, 0.25: 0.25, 0.7: 0.5, 1.0: 0.5, 1.2: 0.3, 1.5: 0.0, 1.59: 0.0, 1.85: 0.25}
    assert {t: pytest.approx(drawn(t - phase_s)) for t in by_hand} == by_hand


def test_phase_is_left_to_chance():
    starts = [draw_profile("stop-and-go", 0.5, np.random.default_rng(s))(0.0) for s in range(200)]
    assert np.mean(np.array(starts) == 0.5) == pytest.approx(0.5 / 1.6, abs=0.1)


@pytest.mark.parametrize("name", MOTIONS)
def test_acceleration_stays_possible(name):
    """The belt of a stop-and-go brakes at 1 m/s²; no other motion is harsher at 0.5 m/s."""
    profile = draw_profile(name, 0.5, np.random.default_rng(1))
    speeds = np.array([profile(time_s) for time_s in TIMES_S])
    assert np.abs(np.diff(speeds)).max() / (TIMES_S[1] - TIMES_S[0]) <= 1.0 + 1e-6


def test_turntable_goes_either_way_round():
    speeds = {draw_profile("turntable", 0.2, np.random.default_rng(s))(1.0) for s in range(20)}
    assert speeds == {-0.2, 0.2}


def test_every_motion_names_a_carrier():
    assert {motion.carrier for motion in MOTIONS.values()} == set(CARRIERS)


def test_bad_motions_are_refused():
    with pytest.raises(
        ValueError, match="motion must be one of constant, ramp, sine, stop-and-go, turntable"
    ):
        draw_profile("zigzag", 0.2, np.random.default_rng(0))
    for speed_mps in (-0.1, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="speed_mps must be finite and >= 0, got"):
            draw_profile("constant", speed_mps, np.random.default_rng(0))
