"""What one image of a flight costs: taking it, finding the target, following corners, all of it.

The camera turns and slides a little from image to image, as in flight.
"""

from contextlib import closing

import cv2
import numpy as np
import pytest

from sim.bearing_only.hall import HallCamera, HallConfig
from tracker.bearing_only.camshift import CamShift, ColourModel
from tracker.bearing_only.corners import CornerTracker
from tracker.bearing_only.image_sensor import ImageSensor

IMAGES = 40
TARGET = np.array([0.0, 15.0, 1.0])


@pytest.fixture(autouse=True)
def one_thread():
    cv2.setNumThreads(1)


@pytest.fixture(scope="module")
def camera():
    rngs = np.random.default_rng(0), np.random.default_rng(1)
    with closing(HallCamera(HallConfig(), *rngs)) as it:
        yield it


def pose(index: int) -> tuple[np.ndarray, np.ndarray]:
    """Back and forth, so that the images can be shown again and again."""
    step = IMAGES - abs(index % (2 * IMAGES) - IMAGES)
    yaw = np.pi + 0.004 * step
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([10.0, 15.0 - 0.1 * step, 1.0]), np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


@pytest.fixture(scope="module")
def images(camera):
    return [camera.photograph(*pose(index), TARGET) for index in range(2 * IMAGES)]


def shown(benchmark, images, look):
    """Benchmarks `look` on the images, one after the other."""
    place = iter(range(10**9))
    benchmark(lambda: look(images[next(place) % len(images)]))


def test_take_an_image(benchmark, camera):
    place = iter(range(10**9))
    benchmark(lambda: camera.photograph(*pose(next(place)), TARGET))


def test_find_the_target(benchmark, camera, images):
    shown(benchmark, images, CamShift(ColourModel(camera.reference_photograph())).update)


def test_find_the_target_in_the_whole_image(benchmark, camera, images):
    model = ColourModel(camera.reference_photograph())
    shown(benchmark, images, lambda image: CamShift(model).update(image))


def test_follow_corners(benchmark, images):
    greys = [cv2.cvtColor(image, cv2.COLOR_RGB2GRAY) for image in images]
    shown(benchmark, greys, CornerTracker().update)


def test_look(benchmark, camera, images):
    """Target, corners and the test of the corners by each other."""
    shown(benchmark, images, ImageSensor(camera.reference_photograph()).look)
