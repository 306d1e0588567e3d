"""Images of the flying camera: noise, repeatability, and corners that stay on the same place."""

import cv2
import numpy as np
import pytest

from sim.bearing_only.hall_camera import HallCamera, HallCameraConfig
from sim.bearing_only.scene import (
    CAMERA,
    CENTRE_PX,
    FOCAL_PX,
    HEIGHT_PX,
    WIDTH_PX,
    FlightSceneConfig,
)
from sim.geometry import R_BODY_CAMERA
from tracker.bearing_only.corners import CornerTracker
from tracker.bearing_only.measurements import PinholeCamera

SMALL = FlightSceneConfig(wall_px_per_m=12.0, crate_count=20)
POSITION, TARGET = np.array([10.0, 15.0, 1.0]), np.array([0.0, 15.0, 1.0])


def facing(yaw: float) -> np.ndarray:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def camera(noise_std: float = 2.0, scene: FlightSceneConfig = SMALL) -> HallCamera:
    rngs = np.random.default_rng(5), np.random.default_rng(6)
    return HallCamera(HallCameraConfig(scene, noise_std), *rngs)


def test_the_estimators_camera_is_the_one_that_renders():
    ours = PinholeCamera()
    assert (ours.s_u_px, ours.s_v_px) == (FOCAL_PX, FOCAL_PX)
    assert (ours.u0_px, ours.v0_px) == CENTRE_PX
    assert (ours.width_px, ours.height_px) == (WIDTH_PX, HEIGHT_PX)


def test_noise_is_as_large_as_said_and_new_in_each_image():
    with camera() as noisy, camera(0.0) as clean:
        still = clean.photograph(POSITION, facing(np.pi), TARGET).astype(float)
        first, second = (noisy.photograph(POSITION, facing(np.pi), TARGET) for _ in range(2))
    assert np.std(first - still) == pytest.approx(2.0, rel=0.05)
    assert np.corrcoef((first - still).ravel(), (second - still).ravel())[0, 1] < 0.02


def test_the_same_streams_take_the_same_images():
    with camera() as one, camera() as two:
        a, b = (c.photograph(POSITION, facing(3.0), TARGET) for c in (one, two))
    assert np.array_equal(a, b)


def test_the_reference_photograph_is_full_of_the_target():
    with camera() as taking:
        hsv = cv2.cvtColor(np.ascontiguousarray(taking.reference_photograph()), cv2.COLOR_RGB2HSV)
    assert np.ptp(hsv[..., 0].astype(int)) <= 8
    assert hsv[..., 1].min() > 180


def test_a_corner_stays_on_the_same_point_of_the_hall():
    """Points of the first image, taken into the hall by their depth, reappear where followed."""
    corners = CornerTracker()
    with camera() as taking:
        image = taking.photograph(POSITION, facing(np.pi), TARGET)
        _, depth_m = taking._renderer.render(taking.scene.model, taking.scene.data, CAMERA)
        first = corners.update(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY))
        column, row = first.pixels.astype(int).T
        z = depth_m[row, column, None]
        c = np.column_stack([(first.pixels - CENTRE_PX) / FOCAL_PX * z, z])
        world = POSITION + c @ (facing(np.pi) @ R_BODY_CAMERA).T
        for step in range(1, 11):
            position = POSITION + 0.12 * step * np.array([-0.3, 1.0, 0.4])
            R = facing(np.pi - 0.01 * step)
            image = taking.photograph(position, R, TARGET)
            seen = corners.update(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY))
    c = (world - position) @ R @ R_BODY_CAMERA
    expected = np.array(CENTRE_PX) + FOCAL_PX * c[:, :2] / c[:, 2:]
    kept = np.isin(seen.ids, first.ids)
    errors = np.linalg.norm(seen.pixels[kept] - expected[seen.ids[kept]], axis=1)
    assert kept.sum() > 20
    assert np.median(errors) < 0.3
    assert np.median(np.linalg.norm(seen.pixels[kept] - first.pixels[seen.ids[kept]], axis=1)) > 5


@pytest.mark.parametrize("noise", [-1.0, float("nan")])
def test_an_impossible_noise_is_refused(noise):
    with pytest.raises(ValueError, match="noise_std"):
        HallCameraConfig(noise_std=noise)
