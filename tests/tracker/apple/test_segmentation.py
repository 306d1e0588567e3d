"""Segmentation on painted images: what is found, what is dropped, and what has a status."""

import cv2
import numpy as np
import pytest

from tracker.apple.segmentation import SegmentationConfig, segment, view_of_masks
from tracker.apple.view import FruitStatus

SKY, SKIN, LEAF, CALYX, STEM = (
    (200, 215, 225),
    (170, 30, 34),
    (66, 126, 44),
    (62, 40, 24),
    (80, 58, 38),
)
CENTRE, SEMI_AXES, ANGLE_DEG = (300.0, 240.0), (70.0, 62.0), 25.0


def ellipse(image, centre, semi_axes, degrees, colour):
    """Paints the pixels whose centres are inside."""
    y, x = np.mgrid[: image.shape[0], : image.shape[1]]
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    x, y = x - centre[0], y - centre[1]
    along, across = (c * x + s * y) / semi_axes[0], (c * y - s * x) / semi_axes[1]
    image[along**2 + across**2 <= 1.0] = colour


def picture(*, fruits=((CENTRE, SEMI_AXES),), calyx=None, noise=3.0, light=1.0):
    image = np.empty((480, 640, 3), np.uint8)
    image[:] = SKY
    for centre, semi_axes in fruits:
        ellipse(image, centre, semi_axes, ANGLE_DEG, SKIN)
    if calyx is not None:
        ellipse(image, calyx, (12, 11), 0.0, CALYX)
    return noisy(image, noise, light)


def noisy(image, noise=3.0, light=1.0):
    rng = np.random.default_rng(0)
    dim = light * image + noise * rng.standard_normal(image.shape)
    return np.clip(np.rint(dim), 0, 255).astype(np.uint8)


def assert_is_the_fruit(view, tolerance_px=0.4):
    assert view.status is FruitStatus.FOUND
    assert view.centre_px == pytest.approx(CENTRE, abs=tolerance_px)
    assert view.semi_axes_px == pytest.approx(SEMI_AXES, abs=tolerance_px)
    assert np.degrees(view.major_angle_rad) == pytest.approx(ANGLE_DEG, abs=3.0)


@pytest.mark.parametrize("light", [0.45, 1.0, 1.3])
def test_the_ellipse_of_a_bare_fruit(light):
    view = segment(picture(light=light))
    assert_is_the_fruit(view)
    assert view.arc_fraction == 1.0
    assert view.calyx_px is None
    assert len(view.contour_px) > 200
    assert view.ellipse_covariance.shape == (5, 5)


def test_the_calyx_is_found_and_no_skin_is_told_there():
    view = segment(picture(calyx=(320.0, 262.0)))
    assert_is_the_fruit(view)
    assert view.calyx_px == pytest.approx([320.0, 262.0], abs=0.5)
    assert np.hypot(*(view.skin_px - [320.0, 262.0]).T).min() > 9.0
    assert view.skin_step_px >= 3.0


def test_skin_lies_on_the_fruit():
    view = segment(picture())
    offset = view.skin_px - CENTRE
    assert len(view.skin_px) > 100
    assert np.hypot(*offset.T).max() < 70.0


def test_a_stem_is_no_part_of_the_outline_and_no_calyx():
    image = picture(noise=0.0)
    cv2.line(image, (300, 190), (318, 120), STEM, 7)
    view = segment(noisy(image))
    assert_is_the_fruit(view, 0.6)
    assert view.calyx_px is None
    red = picture(noise=0.0)
    cv2.line(red, (300, 190), (318, 120), SKIN, 7)  # a stem of the colour of the skin
    assert_is_the_fruit(segment(noisy(red)), 0.8)


def test_leaves_in_front_take_a_part_of_the_outline():
    image = picture(noise=0.0)
    ellipse(image, (245.0, 200.0), (55.0, 28.0), 40.0, LEAF)
    ellipse(image, (360.0, 275.0), (50.0, 24.0), -30.0, LEAF)
    view = segment(noisy(image))
    assert_is_the_fruit(view, 1.0)
    assert 0.3 < view.arc_fraction < 0.9
    x, y = view.contour_px.T
    for cx, cy, reach in ((245.0, 200.0, 18.0), (360.0, 275.0, 16.0)):
        assert np.hypot(x - cx, y - cy).min() > reach


def test_a_leaf_across_the_fruit_leaves_two_pieces_of_one_fruit():
    image = picture(noise=0.0)
    ellipse(image, CENTRE, (95.0, 14.0), 0.0, LEAF)
    assert_is_the_fruit(segment(noisy(image)), 0.6)


def test_leaves_behind_change_nothing():
    image = np.empty((480, 640, 3), np.uint8)
    image[:] = SKY
    ellipse(image, (240.0, 200.0), (70.0, 30.0), 40.0, LEAF)
    ellipse(image, (370.0, 275.0), (60.0, 30.0), -30.0, LEAF)
    ellipse(image, CENTRE, SEMI_AXES, ANGLE_DEG, SKIN)
    view = segment(noisy(image))
    assert_is_the_fruit(view)
    assert view.arc_fraction > 0.95


def test_a_calyx_that_a_leaf_cuts_is_not_told():
    image = picture(noise=0.0, calyx=(320.0, 262.0))
    ellipse(image, (340.0, 270.0), (26.0, 14.0), 20.0, LEAF)
    assert segment(noisy(image)).calyx_px is None


@pytest.mark.parametrize(
    ("image", "status"),
    [
        (picture(fruits=()), FruitStatus.NO_FRUIT),
        (np.zeros((480, 640, 3), np.uint8), FruitStatus.NO_FRUIT),
        (picture(fruits=(((100.0, 100.0), (5.0, 4.5)),)), FruitStatus.NO_FRUIT),
        (picture(fruits=(((40.0, 240.0), (70.0, 62.0)),)), FruitStatus.CUT_BY_BORDER),
        (picture(fruits=(((300.0, 450.0), (70.0, 62.0)),)), FruitStatus.CUT_BY_BORDER),
        (
            picture(fruits=((CENTRE, SEMI_AXES), ((480.0, 200.0), (60.0, 55.0)))),
            FruitStatus.TWO_FRUITS,
        ),
        (
            picture(fruits=((CENTRE, SEMI_AXES), ((390.0, 230.0), (60.0, 55.0)))),
            FruitStatus.TWO_FRUITS,
        ),
    ],
    ids=["sky", "dark", "speck", "left", "below", "two apart", "two that touch"],
)
def test_what_is_no_single_whole_fruit_has_a_status(image, status):
    view = segment(image)
    assert view.status is status
    assert view.centre_px is None and view.calyx_px is None


def test_a_fruit_of_which_little_can_be_seen_is_covered():
    image = picture(noise=0.0)
    ellipse(image, (300.0, 213.0), (120.0, 80.0), 0.0, LEAF)
    assert segment(noisy(image)).status is FruitStatus.COVERED


def test_a_calyx_beyond_the_outline_is_told():
    """A spot within the red region and outside of the ellipse that fits the rest of it."""
    image = picture(noise=0.0)
    ellipse(image, (376.0, 270.0), (17.0, 17.0), 0.0, SKIN)
    ellipse(image, (381.0, 272.0), (9.0, 8.0), 0.0, CALYX)
    assert segment(noisy(image)).status is FruitStatus.CALYX_OUTSIDE


def test_masks_of_an_oracle_take_the_place_of_colours():
    image = picture(calyx=(320.0, 262.0))
    skin = np.zeros((480, 640), np.uint8)
    calyx = skin.copy()
    ellipse(skin, CENTRE, SEMI_AXES, ANGLE_DEG, 1)
    ellipse(calyx, (320.0, 262.0), (12, 11), 0.0, 1)
    told = view_of_masks(np.full_like(image, 128), (skin > calyx), calyx > 0)
    assert_is_the_fruit(told)
    assert told.calyx_px == pytest.approx([320.0, 262.0], abs=0.5)


@pytest.mark.parametrize(
    "image",
    [np.zeros((480, 640), np.uint8), np.zeros((480, 640, 3)), np.zeros((4, 4, 4), np.uint8)],
)
def test_an_array_that_is_no_image_is_refused(image):
    with pytest.raises(ValueError, match=r"rgb must be \(h, w, 3\) uint8, got"):
        segment(image)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"red_ratio": 0.0}, "red_ratio must be a positive number, got 0.0"),
        ({"least_arc": 1.5}, r"least_arc must be in \[0, 1\], got 1.5"),
        ({"calyx_area": (0.2, 0.1)}, "calyx_area must be 0 < low < high <= 1"),
    ],
)
def test_settings_that_make_no_sense_are_refused(values, message):
    with pytest.raises(ValueError, match=message):
        SegmentationConfig(**values)


def test_the_image_is_left_as_it_was_and_the_answer_is_the_same_again():
    image = picture(calyx=(320.0, 262.0))
    before = image.copy()
    first, second = segment(image), segment(image)
    assert np.array_equal(image, before)
    assert np.array_equal(first.contour_px, second.contour_px)
    assert np.array_equal(first.ellipse_covariance, second.ellipse_covariance)
