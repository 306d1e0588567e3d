"""The compiled orchard: what it shows, its light, and a picture that must not change unnoticed."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from sim.apple.world import FREE_CAMERA, HAND_CAMERA, STUDIO, Light
from sim.geometry import look_at

GOLDEN = Path(__file__).with_name("golden.png")


def small(image):
    return cv2.resize(image, (160, 120), interpolation=cv2.INTER_AREA)


def golden_image(make):
    fruit = make["placed"]((0.9, 0.3, 0.4))
    with make["orchard"](fruit, behind=12, in_front=2, seed=5) as orchard:
        orchard.set_free_camera(make["view"](0.35, 0.2))
        return small(orchard.render(FREE_CAMERA, shadows=True))


def test_the_picture_is_the_known_one(make):
    known = cv2.imread(str(GOLDEN))[..., ::-1].astype(int)
    difference = np.abs(golden_image(make).astype(int) - known)
    assert difference.mean() < 2.0
    assert np.percentile(difference, 99) < 25


def test_the_free_camera_stands_where_it_is_put(make):
    T = look_at(np.array([0.4, -0.2, 0.5]), np.array([1.0, 0.1, 0.3]))
    with make["orchard"](make["placed"]()) as orchard:
        orchard.set_free_camera(T)
        assert orchard.camera_pose(FREE_CAMERA) == pytest.approx(T, abs=1e-9)


def test_light_is_a_parameter(make):
    fruit, means = make["placed"](), []
    for light in (Light(lamp=0.6, sky=0.4), Light(lamp=0.2, sky=0.2)):
        with make["orchard"](fruit, light=light) as orchard:
            orchard.set_free_camera(make["view"]())
            mask = orchard.masks(FREE_CAMERA).fruit
            means.append(orchard.render(FREE_CAMERA)[mask].mean())
    assert means[1] < 0.7 * means[0]


def test_a_second_fruit_is_in_the_picture(make):
    second = make["placed"](centre=(1.0, 0.10, 0.3))
    pictures = []
    for others in ((), (second,)):
        with make["orchard"](make["placed"](), others=others) as orchard:
            orchard.set_free_camera(make["view"](0.5))
            pictures.append(orchard.render(FREE_CAMERA).astype(int))
            assert orchard.masks(FREE_CAMERA).fruit.any()
    reds = [(p[..., 0] > 1.7 * np.maximum(p[..., 1], p[..., 2])).sum() for p in pictures]
    assert 1.6 * reds[0] < reds[1] < 2.4 * reds[0]


def test_every_camera_gives_a_picture_with_something_in_it(make):
    with make["orchard"](make["placed"](), behind=3) as orchard:
        for camera in (HAND_CAMERA, FREE_CAMERA, STUDIO):
            image = orchard.render(camera)
            assert image.shape == (480, 640, 3) and image.dtype == np.uint8
        assert orchard.render(STUDIO).std() > 10
        orchard.close()


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"lamp": -0.1}, "lamp must be a number from 0 to 2, got -0.1"),
        ({"sky": 3.0}, "sky must be a number from 0 to 2, got 3.0"),
        ({"direction": (0.0, 0.0, 0.0)}, "direction must be a vector other than zero"),
    ],
)
def test_a_light_that_cannot_be_is_refused(values, message):
    with pytest.raises(ValueError, match=message):
        Light(**values)
