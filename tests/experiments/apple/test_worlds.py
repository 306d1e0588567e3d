"""Worlds by name: what their classes promise, what seeds share, what is refused."""

import numpy as np
import pytest

from experiments.apple.worlds import CLASSES, VIEW_COUNT, WorldId, draw_world

SEEDS = range(1000, 1030)


def angle_deg(a, b):
    return np.degrees(np.arccos(np.clip(a @ b, -1.0, 1.0)))


def test_the_axis_is_as_the_class_says():
    for seed in SEEDS:
        hanging = draw_world(WorldId("hidden", 0.9, seed)).fruit
        assert angle_deg(hanging.axis, np.array([0.0, 0.0, 1.0])) <= 25.0
        facing = draw_world(WorldId("visible", 0.9, seed))
        middle = 0.5 * (facing.approach[3] + facing.approach[4])[:3, 3]
        forward = facing.fruit.centre_m - middle
        forward /= np.linalg.norm(forward)
        assert 10.0 < angle_deg(facing.fruit.axis, forward) < 55.0
        assert (middle - facing.fruit.calyx_m) @ facing.fruit.axis < 0.0


def test_the_approach_comes_nearer_over_fifty_degrees():
    world = draw_world(WorldId("visible", 0.9, 1000))
    offsets = np.array([T[:3, 3] - world.fruit.centre_m for T in world.approach])
    ranges = np.linalg.norm(offsets, axis=1)
    assert len(offsets) == VIEW_COUNT
    assert ranges == pytest.approx(np.linspace(0.60, 0.22, VIEW_COUNT))
    assert angle_deg(offsets[0] / ranges[0], offsets[-1] / ranges[-1]) == pytest.approx(50.0)
    forward = np.array([T[:3, 2] for T in world.approach])
    off_axis = [angle_deg(f, -o / r) for f, o, r in zip(forward, offsets, ranges, strict=True)]
    assert 0.0 < max(off_axis) < 8.0


def test_worlds_of_one_seed_are_paired():
    worlds = {c: draw_world(WorldId(c, a, 1003)) for c in CLASSES for a in (0.85, 0.95)}
    first = worlds["visible"]
    for world in worlds.values():
        assert np.array_equal(world.fruit.centre_m, first.fruit.centre_m)
        assert np.array_equal(world.approach, first.approach)
        assert world.config.light == first.config.light
    assert np.array_equal(worlds["visible-leaves"].fruit.axis, first.fruit.axis)
    assert len(worlds["visible-leaves"].config.leaves) == len(first.config.leaves) + 3
    other = draw_world(WorldId("visible", 0.85, 1004))
    assert not np.array_equal(other.fruit.centre_m, first.fruit.centre_m)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (("visibel", 0.9, 0), "class must be one of visible, hidden, .*did you mean 'visible'"),
        (("visible", 1.1, 0), "aspect must be from 0.5 to below 1, got 1.1"),
        (("visible", 0.9, -1), "seed must be 0 or greater, got -1"),
    ],
)
def test_a_world_that_has_no_name_is_refused(values, message):
    with pytest.raises(ValueError, match=message):
        WorldId(*values)
