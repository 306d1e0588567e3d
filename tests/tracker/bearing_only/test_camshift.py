"""CamShift on painted discs whose places are known."""

import cv2
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from tracker.bearing_only.camshift import CamShift, CamShiftConfig, ColourModel

HEIGHT, WIDTH = 240, 320
COLOUR, OTHER = (220, 26, 107), (40, 90, 150)
PATCH = np.full((20, 20, 3), COLOUR, np.uint8)


def image_of(*discs, noise: int = 0) -> np.ndarray:
    """(h, w, 3) grey image with discs (column, row, radius, colour), from the image's edge."""
    image = np.full((HEIGHT, WIDTH, 3), 130, np.uint8)
    y, x = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    for column, row, radius, colour in discs:
        image[np.hypot(x - column, y - row) <= radius] = colour
    if noise:
        rng = np.random.default_rng(noise)
        return np.uint8(np.clip(image + rng.normal(0, 4, image.shape), 0, 255))
    return image


def tracker(**settings) -> CamShift:
    return CamShift(ColourModel(PATCH, CamShiftConfig(**settings)))


@given(column=st.floats(40, WIDTH - 40), row=st.floats(40, HEIGHT - 40), radius=st.floats(5, 35))
@example(column=40.0, row=40.0, radius=29.0)
def test_the_centre_of_a_disc(column, row, radius):
    """Near the image's edge OpenCV's window is up to a quarter too small; its rim makes up."""
    seen = tracker().update(image_of((column, row, radius, COLOUR), noise=1))
    assert seen.status == "found" and seen.is_whole
    assert np.abs(seen.centre_px - [column, row]).max() < 0.5
    left, top, width, height = seen.window
    assert abs(width - 2 * radius) < 0.5 * radius + 4 and abs(height - width) < 6
    assert left <= column <= left + width and top <= row <= top + height


def test_a_moving_and_growing_disc_is_followed():
    following = tracker()
    for step in range(40):
        place = 60 + 5.0 * step, 120 + 40 * np.sin(0.2 * step)
        radius = 6 + 0.5 * step
        seen = following.update(image_of((*place, radius, COLOUR), noise=step + 1))
        assert seen.status == ("tracked" if step else "found")
        assert np.abs(seen.centre_px - place).max() < 0.5


def test_it_is_lost_and_found_again():
    following = tracker()
    assert following.update(image_of((60, 60, 12, COLOUR))).status == "found"
    for _ in range(3):
        gone = following.update(image_of((60, 60, 12, OTHER), noise=2))
        assert gone.status == "lost" and gone.centre_px is None and gone.window is None
        assert not gone.is_whole
    back = following.update(image_of((250, 180, 9, COLOUR)))
    assert back.status == "found"
    assert np.abs(back.centre_px - [250, 180]).max() < 0.5


def test_a_jump_beyond_its_reach_is_found_in_the_whole_image():
    following = tracker()
    following.update(image_of((40, 40, 8, COLOUR)))
    seen = following.update(image_of((280, 200, 8, COLOUR)))
    assert seen.status == "found"
    assert np.abs(seen.centre_px - [280, 200]).max() < 0.5


@pytest.mark.parametrize("place", [(3, 120), (WIDTH - 4, 120), (160, 2), (160, HEIGHT - 3)])
def test_a_disc_that_the_border_cuts_is_told(place):
    """The centroid of what is left of it is off: pixels of it are, and its status says so."""
    seen = tracker().update(image_of((*place, 14, COLOUR)))
    assert seen.status == "cut" and not seen.is_whole
    assert np.abs(seen.centre_px - place).max() > 2.0


def test_it_leaves_the_image():
    following, told = tracker(), []
    for step in range(30):
        told.append(following.update(image_of((270 + 3 * step, 120, 12, COLOUR))).status)
    assert told[0] == "found" and told[-1] == "lost"
    assert set(told[1:-1]) == {"tracked", "cut", "lost"}
    assert told == sorted(told, key=["found", "tracked", "cut", "lost"].index)


def test_the_largest_blob_is_taken():
    seen = tracker().update(image_of((60, 60, 5, COLOUR), (200, 150, 15, COLOUR)))
    assert np.abs(seen.centre_px - [200, 150]).max() < 0.5


def test_dots_of_its_colour_are_no_target():
    assert tracker().update(image_of((60, 60, 1.2, COLOUR))).status == "lost"


def test_shade_changes_nothing():
    """Half of the ball is darker, of the same hue."""
    image = image_of((160, 120, 15, COLOUR))
    image[120:] = image[120:] // 2
    seen = tracker().update(image)
    assert np.abs(seen.centre_px - [160, 120]).max() < 0.5


def test_a_grey_patch_teaches_nothing():
    with pytest.raises(ValueError, match="no coloured pixel"):
        ColourModel(np.full((9, 9, 3), 99, np.uint8))


def test_likelihood_is_high_on_the_target_alone():
    likelihood = ColourModel(PATCH).likelihood(
        image_of((60, 60, 9, COLOUR), (200, 120, 20, OTHER), noise=3)
    )
    y, x = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    is_target = np.hypot(x - 60, y - 60) <= 9
    assert (likelihood[is_target] > 127).mean() > 0.98
    assert likelihood[~is_target].max() == 0


@pytest.mark.parametrize("image", [np.zeros((9, 9), np.uint8), np.zeros((9, 9, 3))])
def test_what_is_no_image_is_refused(image):
    with pytest.raises(ValueError, match="image must be"):
        tracker().update(image)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"bins": 0}, "bins"),
        ({"bins": 181}, "bins.*181"),
        ({"least_density": 1.2}, "least_density"),
        ({"reach": float("inf")}, "reach"),
    ],
)
def test_impossible_settings_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        CamShiftConfig(**change)


def test_opencv_is_given_an_image_of_any_layout():
    image = np.asfortranarray(image_of((100, 100, 10, COLOUR)))
    assert np.abs(tracker().update(image).centre_px - [100, 100]).max() < 0.5
    flipped = cv2.flip(image, 0)[::-1]
    assert np.abs(tracker().update(flipped).centre_px - [100, 100]).max() < 0.5
