import numpy as np
import pytest
import videos

from tracker.affine import aff2
from tracker.box_tracker import warp_of_box
from tracker.video.correlation import (
    CorrelationConfig,
    CorrelationFilter,
    Response,
    ResponsePyramid,
)

BOX = np.array([60.0, 50.0, *videos.SIZE_PX])
START = warp_of_box(BOX)
UNIT_PX = START[0, 0]
SIZE = (videos.SIZE_PX[0] / UNIT_PX, videos.SIZE_PX[1] / UNIT_PX)
TO_IMAGE = np.array([[2.0, 0, 10.0], [0, 4.0, 20.0], [0, 0, 1.0]])


def shifted(by):
    return START + np.array([[0, 0, by[0]], [0, 0, by[1]], [0, 0, 0]])


@pytest.mark.parametrize("by", [(0.0, 0.0), (7.0, -5.0), (-20.0, 12.0)])
def test_the_peak_lies_where_the_target_went(by):
    images = videos.film([START, shifted(by)])
    tracker = CorrelationFilter(CorrelationConfig(), SIZE, 48.0)
    tracker.start(images[0], START)
    response = tracker.respond(images[1], START)
    np.testing.assert_allclose(response.peak_px, START[:2, 2] + by, atol=1.5)
    assert response.peak > 0.3
    tracker.learn(images[1], shifted(response.peak_px - START[:2, 2]))
    again = tracker.respond(images[1], START)
    np.testing.assert_allclose(again.peak_px, START[:2, 2] + by, atol=1.5)


def test_the_score_of_the_target_as_learnt_is_one():
    image = videos.film([START])[0]
    for support in (1.0, 1.5, 3.0):
        tracker = CorrelationFilter(CorrelationConfig(support=support), SIZE, 32.0)
        tracker.start(image, START)
        again = tracker.respond(image, START)
        assert again.peak == pytest.approx(1.0, abs=1e-6)


def test_a_window_that_turns_with_the_target_sees_it_as_learnt():
    """By 60 degrees and 9 px: the scores are laid over the image as the window lies in it."""
    turned = START @ aff2.similarity(1.0, np.radians(60), np.zeros(2))
    turned[:2, 2] += (7.0, -5.0)
    images = videos.film([START, turned])
    tracker = CorrelationFilter(CorrelationConfig(), SIZE, 48.0)
    tracker.start(images[0], START)
    pose = turned.copy()
    pose[:2, 2] = START[:2, 2]
    response = tracker.respond(images[1], pose)
    np.testing.assert_allclose(response.peak_px, turned[:2, 2], atol=1.5)
    assert response.peak > 2 * tracker.respond(images[1], START).peak


@pytest.mark.parametrize("turn_deg", [0.0, 35.0])
@pytest.mark.parametrize("by", [(0.0, 0.0), (130.0, 90.0), (-20.0, 100.0)])
def test_the_peak_in_the_whole_image_lies_where_the_target_went(by, turn_deg):
    """With even and odd numbers of cells in the window."""
    turned = START @ aff2.similarity(1.0, np.radians(turn_deg), np.zeros(2))
    there = turned.copy()
    there[:2, 2] += by
    images = videos.film([turned, there])
    for unit_px in (32.0, 33.5):
        tracker = CorrelationFilter(CorrelationConfig(), SIZE, unit_px)
        tracker.start(images[0], turned)
        everywhere = tracker.respond_everywhere(images[1], turned)
        np.testing.assert_allclose(everywhere.peak_px, there[:2, 2], atol=2.0)
        assert everywhere.peak > 0.4


def test_a_search_of_the_whole_image_stays_small_for_the_smallest_target():
    image = videos.film([START])[0]
    pose = aff2.similarity(0.5, 0.0, START[:2, 2])
    tracker = CorrelationFilter(CorrelationConfig(), SIZE, 32.0)
    tracker.start(image, pose)
    assert max(tracker.respond_everywhere(image, pose).scores.shape) <= 402


def test_ground_that_stays_does_not_hold_the_score_where_the_target_was():
    images = videos.film([START, shifted((26.0, 10.0))])
    places = np.stack([START[:2, 2], START[:2, 2] + (26.0, 10.0)])
    left = {}
    for support in (1.2, 3.5):
        tracker = CorrelationFilter(CorrelationConfig(support=support), SIZE, 32.0)
        tracker.start(images[0], START)
        there_before, here = tracker.respond(images[1], START).at(places)
        left[support] = there_before - here
    assert left[1.2] < 0.0 < left[3.5]


def test_scores_between_cells_are_interpolated_and_nothing_lies_outside():
    scores = np.arange(12, dtype=np.float32).reshape(3, 4)
    response = Response(scores, TO_IMAGE)
    points = np.array([[10.0, 20.0], [13.0, 20.0], [12.0, 26.0], [100.0, 20.0]])
    np.testing.assert_allclose(response.at(points), [0.0, 1.5, 7.0, 0.0], atol=1e-5)
    np.testing.assert_allclose(response.peak_px, [16.0, 28.0])


def test_places_are_drawn_where_the_scores_are_high():
    scores = np.zeros((5, 7), np.float32)
    scores[1, 2], scores[4, 6] = 1.0, 0.9
    response = Response(scores, TO_IMAGE)
    places = response.draw(4000, 20.0, np.random.default_rng(0))
    at_first = np.abs(places - [14.0, 24.0]) <= [1.0, 2.0]
    at_second = np.abs(places - [22.0, 36.0]) <= [1.0, 2.0]
    shares = at_first.all(axis=1).mean(), at_second.all(axis=1).mean()
    assert sum(shares) > 0.999
    assert shares[0] / shares[1] == pytest.approx(np.exp(20.0 * 0.1), rel=0.15)


def test_scores_between_sizes_are_interpolated_and_the_last_hold_beyond():
    levels = [Response(np.full((3, 3), score, np.float32), np.eye(3)) for score in (1, 3, 2)]
    pyramid = ResponsePyramid(tuple(levels), np.log([8.0, 10.0, 12.5]))
    assert pyramid.best is levels[1]
    sizes = np.log([5.0, 8.0, np.sqrt(80.0), 10.0, 12.5, 20.0])
    np.testing.assert_allclose(pyramid.at(np.ones((6, 2)), sizes), [1, 1, 2, 3, 2, 2])
    alone = ResponsePyramid((levels[0],), np.log([8.0]))
    np.testing.assert_allclose(alone.at(np.ones((6, 2)), sizes), 1.0)


@pytest.mark.parametrize(("growth", "level"), [(1 / 1.1, 0), (1.0, 1), (1.1, 2)])
def test_the_right_size_has_the_largest_score(growth, level):
    images = videos.film([START, START @ np.diag([growth, growth, 1.0])])
    tracker = CorrelationFilter(CorrelationConfig(scales=3, scale_step=1.1), SIZE, 48.0)
    tracker.start(images[0], START)
    pyramid = tracker.search(images[1], START)
    assert pyramid.best is pyramid.levels[level]


@pytest.mark.parametrize(("field", "value"), [("scales", 0), ("scale_step", 1.0)])
def test_bad_sizes_are_refused(field, value):
    with pytest.raises(ValueError, match=field):
        CorrelationConfig(**{field: value})


@pytest.mark.parametrize(
    "field", ["padding", "support", "learning_rate", "regularisation", "target_width"]
)
def test_bad_settings_are_refused(field):
    with pytest.raises(ValueError, match=field):
        CorrelationConfig(**{field: 0.0})
