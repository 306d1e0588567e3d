"""The image sensor as a whole, on painted images."""

import cv2
import numpy as np
import pytest

from tracker.bearing_only.image_sensor import ImageSensor, ImageSensorConfig

COLOUR = (220, 26, 107)
HEIGHT, WIDTH = 240, 320


@pytest.fixture(scope="module")
def wall() -> np.ndarray:
    rng = np.random.default_rng(2)
    picture = np.full((2 * HEIGHT, 2 * WIDTH, 3), 120, np.uint8)
    for y in range(15, 2 * HEIGHT, 34):
        for x in range(15, 2 * WIDTH, 34):
            points = np.int32(np.add([x, y], rng.uniform(-12, 12, (4, 2))))
            cv2.fillPoly(picture, [points], [int(rng.choice([25, 70, 190, 235]))] * 3)
    return picture


def image_of(wall: np.ndarray, step: int, disc: tuple[int, int] | None) -> np.ndarray:
    image = wall[40 + step : 40 + step + HEIGHT, 60 + 2 * step : 60 + 2 * step + WIDTH].copy()
    if disc is not None:
        cv2.circle(image, disc, 15, COLOUR, -1)
    return image


def sensor() -> ImageSensor:
    return ImageSensor(np.full((20, 20, 3), COLOUR, np.uint8))


def test_landmarks_stand_still_on_the_wall_and_the_target_moves(wall):
    looking, first = sensor(), {}
    for step in range(25):
        disc = 60 + 8 * step, 120
        measurement = looking.look(image_of(wall, step, disc))
        assert np.abs(measurement.target_px - (np.array(disc) + 0.5)).max() < 0.3
        places = measurement.features.pixels + np.array([2 * step, step])
        for name, place in zip(measurement.features.ids.tolist(), places, strict=True):
            assert np.abs(place - first.setdefault(name, place)).max() < 0.7
            gap = np.abs(place - [2 * step, step] - disc)
            assert (gap > 15 + ImageSensorConfig().rim_px - 4).any()
    assert len(measurement.features.ids) > 15


def test_a_target_out_of_view_or_at_the_border_has_no_pixel(wall):
    looking = sensor()
    assert looking.look(image_of(wall, 0, (WIDTH - 30, 120))).target_px is not None
    cut = looking.look(image_of(wall, 1, (WIDTH - 4, 120)))
    assert cut.sighting.status == "cut" and cut.target_px is None
    gone = looking.look(image_of(wall, 2, None))
    assert gone.sighting.status == "lost" and gone.target_px is None
    assert len(gone.features.ids) > 15


def test_an_impossible_rim_is_refused():
    with pytest.raises(ValueError, match="rim_px"):
        ImageSensorConfig(rim_px=-1)
