import numpy as np
import pytest
import videos

from tracker.affine import aff2
from tracker.affine.likelihood import LikelihoodConfig
from tracker.box_tracker import warp_of_box
from tracker.video.appearance import AppearanceConfig
from tracker.video.refinement import Refinement, RefinementConfig
from tracker.video.window import cut_window

BOX = np.array([60.0, 50.0, *videos.SIZE_PX])
START = warp_of_box(BOX)
LIKELIHOOD = LikelihoodConfig(shape_std=None)
MOVED = aff2.perturb(START, np.array([0.02, 0.01, 0.1, 0.01, 0.15, -0.1]))


def window(image):
    return cut_window(image, START[:2, 2], START[0, 0], 2.5, 32)


def refinement(image, config=None):
    config = config or RefinementConfig()
    return Refinement(config, AppearanceConfig(), LIKELIHOOD, window(image), BOX)


def test_an_estimate_with_noise_becomes_exact():
    first, second = videos.film([START, MOVED])
    rng = np.random.default_rng(0)
    refine = refinement(first).refine
    before = 0.03 * rng.standard_normal((20, 6))
    after = [
        aff2.difference(MOVED, refine(window(second), aff2.perturb(MOVED, e), 0.3)) for e in before
    ]
    assert np.median(np.linalg.norm(after, axis=1)) < 0.2 * np.median(
        np.linalg.norm(before, axis=1)
    )


def test_an_estimate_that_fits_better_stays():
    """Far from the target the steps lead anywhere."""
    first, second = videos.film([START, MOVED])
    look = refinement(first)
    far = aff2.perturb(START, np.array([0, 0, 0, 0, 1.1, 0.9]))
    ncc = []
    for steps in (1, 2, 8):
        refined = refinement(first, RefinementConfig(steps=steps)).refine(window(second), far, 0.3)
        layers = look._look.layers(window(second))
        pair = [look._look.fit(layers, window(second).to_window @ X).ncc for X in (far, refined)]
        ncc.append(pair)
    assert all(after >= before for before, after in ncc)


def test_it_learns_what_it_is_told_to_learn():
    first, second = videos.film([START, START], noise=20.0)
    look = refinement(first)
    before = look._look.matcher
    look.learn()
    assert look._look.matcher is before
    look.refine(window(second), START, 0.3)
    look.learn()
    assert look._look.matcher is not before


@pytest.mark.parametrize(("field", "value"), [("steps", 0), ("blur", 0.0)])
def test_bad_settings_are_refused(field, value):
    with pytest.raises(ValueError, match=field):
        RefinementConfig(**{field: value})
