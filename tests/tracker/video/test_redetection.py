import numpy as np
import pytest
import videos

from tracker.affine.template import Template
from tracker.box_tracker import warp_of_box
from tracker.video.redetection import LossMonitor, RedetectionConfig, whole_image_response

BOX = np.array([150.0, 110.0, *videos.SIZE_PX])


@pytest.mark.parametrize("resolution", [12.0, 16.0, 64.0])
def test_the_peak_lies_on_the_target_wherever_it_is(resolution):
    warp = warp_of_box(BOX)
    image = videos.film([warp])[0]
    x, y, w, h = BOX.astype(int)
    template = Template.of_picture(image[y : y + h, x : x + w].copy(), (w, h), (32, 32))
    response = whole_image_response(image, template, 0.02, float(np.sqrt(w * h)), resolution)
    np.testing.assert_allclose(response.peak_px, warp[:2, 2], atol=2.5)
    assert response.peak > 0.8


@pytest.mark.parametrize("unit_px", [2.0, 5000.0])
def test_any_size_of_the_template_gives_finite_scores(unit_px):
    image = videos.film([warp_of_box(BOX)])[0]
    template = Template.of_picture(image[:40, :60].copy(), (60, 40), (32, 32))
    response = whole_image_response(image, template, 0.1, unit_px, 16.0)
    assert np.isfinite(response.scores).all()
    places = response.draw(50, 20.0, np.random.default_rng(0))
    assert (places > -20).all()
    assert (places < 260).all()


def test_lost_is_who_was_missed_often_enough_in_a_row():
    monitor = LossMonitor(RedetectionConfig(patience=3), np.eye(3))
    for confidence, is_missed in [(0.5, False), (0.19, True), (0.5, False), *[(0.1, True)] * 2]:
        monitor.note(confidence, (1 + confidence) * np.eye(3))
        assert monitor.is_missed == is_missed
        assert not monitor.is_lost
    monitor.note(0.1, np.zeros((3, 3)))
    assert monitor.is_lost
    np.testing.assert_array_equal(monitor.last_good_warp, 1.5 * np.eye(3))


def test_found_again_takes_more_confidence_than_not_lost():
    monitor = LossMonitor(RedetectionConfig(patience=1), np.eye(3))
    monitor.note(0.5, np.eye(3))
    monitor.note(0.21, np.eye(3))
    assert not monitor.is_lost
    monitor.note(0.1, np.eye(3))
    monitor.note(0.21, np.eye(3))
    assert monitor.is_lost
    monitor.note(0.31, np.eye(3))
    assert not monitor.is_lost


def test_the_average_follows_a_target_that_changes_but_no_gap():
    monitor = LossMonitor(RedetectionConfig(memory=0.5, patience=2), np.eye(3))
    for confidence in [1.0, 0.5, 0.4, 0.3]:
        monitor.note(confidence, np.eye(3))
    monitor.note(0.25, np.eye(3))
    assert not monitor.is_missed
    for _ in range(20):
        monitor.note(0.05, np.eye(3))
    assert monitor.is_lost


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("missed_share", 1.2),
        ("found_share", -0.1),
        ("memory", 1.1),
        ("share", -0.1),
        ("patience", 0),
        ("sharpness", 0.0),
        ("resolution", -1),
    ],
)
def test_bad_settings_are_refused(field, value):
    with pytest.raises(ValueError, match=field):
        RedetectionConfig(**{field: value})
