"""A fruit in the orchard, alone or between leaves, and a camera in front of it."""

import numpy as np
import pytest

from sim.apple.fruit import Fruit, PlacedFruit
from sim.apple.leaves import leaves_behind, leaves_in_front
from sim.apple.world import Light, Orchard, OrchardConfig
from sim.geometry import look_at

CENTRE = np.array([1.0, 0.0, 0.3])


def placed(axis=(0.3, 0.1, 1.0), aspect=0.85, centre=CENTRE):
    axis = np.array(axis, float)
    return PlacedFruit(Fruit(aspect=aspect), np.array(centre), axis / np.linalg.norm(axis))


def view(range_m=0.35, turn_rad=0.0, at=CENTRE):
    back = np.array([-np.cos(turn_rad), np.sin(turn_rad), 0.0])
    return look_at(at + range_m * back, at)


def orchard(fruit, behind=0, in_front=0, light=None, others=(), seed=0):
    rng = np.random.default_rng(seed)
    frame = view()[:3, :3]
    leaves = leaves_behind(rng, fruit.centre_m, frame, behind)
    leaves += leaves_in_front(rng, fruit.centre_m, frame, fruit.fruit.radius_m, in_front)
    config = OrchardConfig(fruit, others=others, leaves=leaves, light=light or Light())
    return Orchard(config, np.random.default_rng(seed))


@pytest.fixture(scope="session")
def make():
    """Builds orchards, fruits and views."""
    return {"orchard": orchard, "placed": placed, "view": view}
