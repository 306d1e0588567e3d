"""What joint speeds and reach allow, against what can be worked out by hand."""

import math

import numpy as np
import pytest

from sim.arm.embodiments import RG2, UR3_SOFT, UR5_RG2
from sim.belt.interception import (
    FollowingSpeed,
    closing_time_s,
    following_speed,
    interceptable_share,
)

TCP_Z_M = 0.045


@pytest.fixture(scope="module")
def middle():
    return following_speed(UR5_RG2, 0.0, TCP_Z_M)


@pytest.mark.parametrize("offset_m", [-0.08, 0.0, 0.08])
def test_in_front_of_the_robot_the_base_sweeps_at_its_limit(offset_m):
    """There the hand's speed is pi rad/s times its distance of 0.5 m + offset from the base."""
    found = following_speed(UR5_RG2, offset_m, TCP_Z_M)
    speed = np.interp(0.0, found.y_m, found.speed_mps)
    assert speed == pytest.approx(math.pi * (0.5 + offset_m), rel=2e-3)


def test_the_slower_of_two_arms_is_the_one_nearer_to_the_belt():
    """pi rad/s at 0.32 m, as the wrist is twice as fast; interpolated between places on a curve."""
    found = following_speed(UR3_SOFT, 0.0, TCP_Z_M)
    speed = np.interp(0.0, found.y_m, found.speed_mps)
    assert speed == pytest.approx(math.pi * 0.32, rel=6e-3)


def test_the_arm_reaches_as_far_to_both_sides(middle):
    assert middle.y_m[0] == pytest.approx(-middle.y_m[-1], abs=0.05)
    assert 0.6 < middle.y_m[-1] < 0.85, "the arm is 0.82 m long from shoulder to wrist"
    assert np.all(middle.speed_mps > 0.0)


def test_a_flat_limit_gives_the_shorter_of_limit_and_window():
    flat = FollowingSpeed(np.linspace(-0.5, 0.5, 26), np.full(26, 2.0))
    assert flat.fastest_belt_mps(0.1) == pytest.approx(2.0, abs=1e-3)
    assert flat.fastest_belt_mps(1.0) == pytest.approx(1.0, abs=0.01)


def test_a_gap_in_the_middle_leaves_the_longer_side():
    y_m = np.linspace(-0.5, 0.5, 101)
    split = FollowingSpeed(y_m, np.where((y_m > 0.0) & (y_m < 0.1), 0.5, 2.0))
    assert split.fastest_belt_mps(0.5) == pytest.approx(1.0, abs=0.02)


def test_fingers_close_in_the_time_of_their_way():
    assert closing_time_s(RG2, 0.110, 0.05) == pytest.approx(0.05)
    assert closing_time_s(RG2, 0.110 - 0.127, 0.0) == pytest.approx(1.0)


def test_the_share_falls_from_all_to_none():
    share = interceptable_share(
        UR5_RG2, np.array([0.5, 1.2, 1.6, 2.5]), (-0.08, 0.08), TCP_Z_M, 0.29
    )
    assert share[0] == share[1] == 1.0 and 0.0 < share[2] < 1.0 and share[3] == 0.0
