import cv2
import numpy as np
import pytest

from tracker.affine.likelihood import LikelihoodConfig, TemplateObservation
from tracker.affine.patches import Layers, PatchMatcher
from tracker.belt.image import ArrayImage
from tracker.video.window import Window, WindowObservation, cut_window


def ramp(height=90, width=160):
    """BGR image whose grey value at (x, y) is x + y."""
    y, x = np.mgrid[0:height, 0:width]
    return cv2.merge([(x + y).astype(np.uint8)] * 3)


@pytest.mark.parametrize("centre", [(80.0, 45.0), (5.0, 4.0), (158.0, 88.0)])
@pytest.mark.parametrize("unit_px", [20.0, 64.0])
def test_pixels_lie_where_the_transform_says(centre, unit_px):
    """Half a pixel wrong along either axis would show as half a grey level."""
    window = cut_window(ramp(), np.array(centre), unit_px, reach=1.0, resolution=32.0)
    rows, columns = window.grey.shape
    inner = np.mgrid[2 : rows - 2, 2 : columns - 2].reshape(2, -1)
    places = np.stack([inner[1], inner[0], np.ones(inner.shape[1])])
    x, y, _ = np.linalg.inv(window.to_window) @ places
    error = window.grey[inner[0], inner[1]] - (x + y)
    assert abs(error.mean()) < 0.3  # grey levels are whole
    assert np.abs(error).max() < 1.1  # rounding of the image, interpolated


@pytest.mark.parametrize("centre", [(-500.0, 60.0), (1e4, 1e4)])
def test_a_target_outside_leaves_a_small_window_at_the_border(centre):
    window = cut_window(ramp(), np.array(centre), 30.0, reach=1.0, resolution=30.0)
    assert min(window.grey.shape) >= 8


def test_an_observation_of_the_window_answers_for_the_whole_image(template, view, scene, true_warp):
    image = view.rectify(ArrayImage(*scene.render(0.5, 0.0, 0.4)))
    whole = Layers.of(image.grey)
    shift = np.array([[1, 0, -7.0], [0, 1, -5.0], [0, 0, 1]])
    matcher, config = PatchMatcher(template), LikelihoodConfig(shape_std=None)
    direct = TemplateObservation(matcher, whole, config, 0.3)
    part = Layers.of(image.grey[5:, 7:])
    inner = TemplateObservation(matcher, part, config, 0.3)
    windowed = WindowObservation(Window(part.grey, shift), (inner,))
    warps = true_warp(0.5, 0.0, 0.4)[None]
    np.testing.assert_allclose(
        windowed.log_likelihood(warps), direct.log_likelihood(warps), rtol=1e-3
    )
    for a, b in zip(windowed.linearise(warps), direct.linearise(warps), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-2, atol=1e-2 * np.abs(b).max())
