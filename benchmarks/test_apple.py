"""The attitude of a fruit: one image by the perspective formulas, the joint fit, the next view."""

import importlib.util
import math
import sys
from pathlib import Path

import numpy as np
import pytest

from tracker.apple.attitude import axis_error_deg
from tracker.apple.next_view import predicted_sigmas_deg, views_around
from tracker.apple.silhouette_fit import fit_silhouettes
from tracker.apple.single_view import measure

FRUITS = Path(__file__).parents[1] / "tests" / "tracker" / "apple" / "fruits.py"


@pytest.fixture(scope="module")
def fruits():
    spec = importlib.util.spec_from_file_location("fruits", FRUITS)
    module = importlib.util.module_from_spec(spec)
    sys.modules["fruits"] = module
    spec.loader.exec_module(module)
    return module


def views_of(fruits, count, leaf_count=0):
    rng = np.random.default_rng(0)
    fruit = fruits.hanging(rng)
    leaves = fruits.leaves_before(rng, leaf_count)
    return fruit, [fruits.noisy(fruit, p, rng, leaves=leaves) for p in fruits.approach(count)]


@pytest.mark.parametrize("kind", ["hanging", "facing"])
def test_one_view(benchmark, fruits, kind):
    rng = np.random.default_rng(0)
    fruit = getattr(fruits, kind)(rng)
    sighting = fruits.noisy(fruit, fruits.approach(1)[0], rng)
    assert benchmark(lambda: measure(sighting)) is not None


@pytest.mark.parametrize(("count", "leaf_count"), [(5, 0), (5, 3), (8, 0)])
def test_joint_fit(benchmark, fruits, count, leaf_count):
    fruit, views = views_of(fruits, count, leaf_count)
    fit = benchmark(lambda: fit_silhouettes(views))
    assert axis_error_deg(fit.axis, fruit.axis) < 5.0


def test_next_best_of_30_views(benchmark, fruits):
    _, views = views_of(fruits, 4)
    fit = fit_silhouettes(views)
    back = views[-1].pose.position_m - fit.fruit.centre_m
    candidates = views_around(fit.fruit.centre_m, back, 0.3, math.radians(50.0), 30)
    sigmas = benchmark(lambda: predicted_sigmas_deg(fit, candidates, fruits.K, fruits.SIZE_PX))
    assert np.isfinite(sigmas).any()
