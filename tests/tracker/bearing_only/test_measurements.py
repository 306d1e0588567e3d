import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tracker.bearing_only.control import aim
from tracker.bearing_only.measurements import (
    BodyIncrement,
    FeatureObservation,
    Measurements,
    PinholeCamera,
)
from tracker.geometry import rotation_of_euler

CAMERA = PinholeCamera()


@given(arrays(float, (5, 2), elements=st.floats(0.0, 480.0)), st.floats(0.5, 80.0))
def test_projecting_a_ray_gives_its_pixel_back(pixels, depth):
    assert np.allclose(CAMERA.project(depth * CAMERA.rays(pixels)), pixels, atol=1e-9)


def test_pixels_by_hand():
    # 1 m to the right and 0.5 m down at 2 m: 320 + 160, 240 + 80.
    assert np.allclose(CAMERA.project(np.array([1.0, 0.5, 2.0])), [480.0, 320.0])
    assert np.allclose(CAMERA.rays_body(np.array([320.0, 240.0])), [1.0, 0.0, 0.0])


@given(arrays(float, 2, elements=st.floats(0.0, 480.0)))
def test_the_aim_brings_the_target_to_the_middle_of_the_image(pixel):
    """[Wu2022] Eqs. 11 to 13, after normalising."""
    ray = CAMERA.rays_body(pixel)
    turn = aim(ray)
    assert turn[0] == 0.0
    assert np.allclose(rotation_of_euler(turn).T @ ray, [1.0, 0.0, 0.0], atol=1e-9)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: BodyIncrement([0.0, np.nan, 0.0], np.zeros(3)), "displacement_m must be finite"),
        (lambda: BodyIncrement(np.zeros(2), np.zeros(3)), "must have 3 numbers"),
        (lambda: FeatureObservation([1, 1], np.zeros((2, 2))), "ids must differ, got 1 twice"),
        (lambda: FeatureObservation([1], np.zeros((2, 2))), "as many, got 1 and 2"),
        (lambda: FeatureObservation([1], [[np.inf, 0.0]]), "finite numbers, got inf"),
        (lambda: Measurements(BodyIncrement.none(), target_px=[0.0, np.nan]), "target_px must be"),
        (lambda: PinholeCamera(s_u_px=0.0), "s_u_px must be a positive number, got 0.0"),
    ],
)
def test_bad_measurements_are_named(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_measurements_cannot_be_changed():
    increment = BodyIncrement(np.zeros(3), np.zeros(3))
    with pytest.raises(ValueError, match="read-only"):
        increment.displacement_m[0] = 1.0
