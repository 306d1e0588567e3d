"""How far the hand is from its grasp; the run-up to a target; ramps that brake in time."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.arm.motion import Ramp, UniformMotion, run_up, servo_error, top_down_pose


def test_servo_error_is_zero_at_the_grasp_and_counts_both_parts():
    motion = UniformMotion(np.array([0.52, 0.0, 0.08]), 0.3, np.array([0.0, 0.25, 0.0]))
    depth = 0.035
    grasp_position = motion.position_m - [0.0, 0.0, depth]
    exact = top_down_pose(grasp_position, 0.3 + math.pi / 2)
    assert servo_error(motion, exact, depth) == pytest.approx(0.0, abs=1e-12)
    turned = top_down_pose(grasp_position, 0.3 + math.pi / 2 + 0.2)
    assert servo_error(motion, turned, depth) == pytest.approx(0.02)
    shifted = top_down_pose(grasp_position + np.array([0.03, 0.0, 0.04]), 0.3 - math.pi / 2)
    assert servo_error(motion, shifted, depth) == pytest.approx(0.05)


@given(st.floats(0.01, 1.5), st.floats(1.0, 10.0))
def test_run_up_meets_the_target_smoothly(speed_mps, acceleration):
    wait = -0.6
    length = speed_mps**2 / (2 * acceleration)
    assert run_up(wait - length, speed_mps, wait, acceleration) == pytest.approx((wait, 0.0))
    end, end_speed = run_up(wait + length, speed_mps, wait, acceleration)
    assert (end, end_speed) == pytest.approx((wait + length, speed_mps))
    dt = 1e-6
    y = wait + 0.3 * length
    here, velocity = run_up(y, speed_mps, wait, acceleration)
    later, _ = run_up(y + speed_mps * dt, speed_mps, wait, acceleration)
    assert (later - here) / dt == pytest.approx(velocity, abs=1e-3 + 1e-3 * speed_mps)


def test_target_that_comes_the_other_way_is_met_where_it_is():
    assert run_up(0.1, -0.25, -0.6, 4.0) == (0.1, -0.25)
    assert run_up(-0.7, -0.25, -0.6, 4.0) == (-0.6, 0.0)
    assert run_up(-0.7, 0.0, -0.6, 4.0) == (-0.6, 0.0)


@given(st.floats(-1.0, 1.0), st.floats(0.1, 2.0), st.floats(1.0, 10.0))
def test_ramp_arrives_within_its_limits(goal, fastest, acceleration):
    ramp, dt_s = Ramp(0.0), 1 / 120
    for _ in range(120 * 12):
        before, speed = ramp.value, ramp.speed
        ramp.step(goal, fastest, acceleration, dt_s)
        assert abs(ramp.speed) <= fastest + 1e-12
        assert abs(ramp.speed - speed) <= acceleration * dt_s + 1e-12
        assert ramp.value == pytest.approx(before + ramp.speed * dt_s)
    assert ramp.value == pytest.approx(goal, abs=1e-6)
