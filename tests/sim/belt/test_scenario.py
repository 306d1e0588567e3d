"""Worlds by seed: where the object starts, on the belt and on the turntable."""

import math
from dataclasses import astuple

import numpy as np
import pytest

from sim.belt.conveyor import BELT_CENTRE_X_M
from sim.belt.scenario import ScenarioRange
from sim.belt.turntable import CENTRE_M, DISC_RADIUS_M, RADIUS_M


def draw(motion: str, seed: int):
    return ScenarioRange().draw(motion, 0.2, np.random.default_rng(seed))


def test_seed_decides_the_world():
    assert draw("sine", 1) == draw("sine", 1) != draw("sine", 2)


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
