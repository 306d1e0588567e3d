"""Belt motions: never backwards, as fast as they say, at a phase that chance decides."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.belt.carriers import CARRIERS
from sim.belt.motions import MOTIONS, RampSpeed, StopAndGoSpeed, draw_profile

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
    assert RampSpeed(0.1, 0.3, 2.0)(1.0) == pytest.approx(0.2)
    ends = {round(draw_profile("ramp", 0.2, np.random.default_rng(s))(9.0), 9) for s in range(20)}
    assert ends == {0.1, 0.3}


def test_stop_and_go_by_hand():
    """Up in 0.5 s, on until 1.0 s, down until 1.5 s, still until 1.6 s."""
    profile = StopAndGoSpeed(0.5, run_s=1.0, stand_s=0.6, acceleration_mps2=1.0, phase_s=0.0)
    by_hand = {0.0: 0.0, 0.25: 0.25, 0.7: 0.5, 1.0: 0.5, 1.2: 0.3, 1.5: 0.0, 1.59: 0.0, 1.85: 0.25}
    assert {t: pytest.approx(profile(t)) for t in by_hand} == by_hand


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
