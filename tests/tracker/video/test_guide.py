import numpy as np
import pytest
import videos

from tracker.affine import aff2
from tracker.box_tracker import warp_of_box
from tracker.video.guide import Guide, GuideConfig

BOX = np.array([96.0, 72.0, *videos.SIZE_PX])
START = warp_of_box(BOX)
SIZE = (videos.SIZE_PX[0] / START[0, 0], videos.SIZE_PX[1] / START[0, 0])


def turned(deg):
    return START @ aff2.similarity(1.0, np.radians(deg), np.zeros(2))


def test_a_turn_that_the_particles_follow_keeps_the_score():
    """Once around a quarter, five degrees an image."""
    warps = [turned(5 * k) for k in range(19)]
    images = videos.film(warps)
    ends = {}
    for is_turning in (True, False):
        guide = Guide(GuideConfig(is_turning=is_turning), SIZE, images[0], START)
        for before, image, warp in zip(warps, images[1:], warps[1:], strict=False):
            guidance = guide.search(image, before)
            guide.learn(image, warp)
        ends[is_turning] = guidance.scores(warps[-1][None])[0]
    assert ends[True] > 0.4
    assert ends[True] > 1.5 * ends[False]


def test_a_turn_that_the_picture_does_not_show_is_not_taken():
    images = videos.film([START] * 8)
    calm, misled = (Guide(GuideConfig(), SIZE, images[0], START) for _ in range(2))
    for image in images[1:]:
        expected, guidance = calm.search(image, START), misled.search(image, turned(25))
        calm.learn(image, START)
        misled.learn(image, turned(25))
    assert guidance.response.best.peak == pytest.approx(expected.response.best.peak, rel=1e-6)


def test_a_target_is_found_anywhere_in_the_image():
    away = START + np.array([[0, 0, -70.0], [0, 0, 50.0], [0, 0, 0]])
    first, second = videos.film([START, away])
    place = Guide(GuideConfig(), SIZE, first, START).find(second, START)
    np.testing.assert_allclose(place, away[:2, 2], atol=2.0)


def test_scores_weigh_in_the_likelihood_but_never_against():
    image = videos.film([START])[0]
    guidance = Guide(GuideConfig(weight=10.0), SIZE, image, START).search(image, START)
    warps = np.stack([START, START + np.array([[0, 0, 40.0], [0, 0, 30.0], [0, 0, 0]])])
    value = guidance.log_likelihood(warps)
    assert value[0] == pytest.approx(10.0 * guidance.scores(warps)[0])
    assert value.min() >= 0.0
    assert value[0] > 5 * value[1]


def test_places_are_a_share_of_the_particles():
    image = videos.film([START])[0]
    guidance = Guide(GuideConfig(jump_share=0.25), SIZE, image, START).search(image, START)
    places = guidance.draw_places(80, np.random.default_rng(0))
    assert places.shape == (20, 2)
    np.testing.assert_allclose(np.median(places, axis=0), START[:2, 2], atol=3)


@pytest.mark.parametrize("field", ["jump_share", "resolution", "weight"])
def test_bad_settings_are_refused(field):
    with pytest.raises(ValueError, match=field):
        GuideConfig(**{field: -1.0})
