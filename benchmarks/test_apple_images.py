"""One image of an apple, from pixels to attitude, on one core at 640 x 480: 5 ms are allowed."""

import cv2
import numpy as np
import pytest

import sim  # noqa: F401
from experiments.apple.photographs import SEGMENTED, ArmPhotographer, sighting
from experiments.apple.worlds import CLASSES, WorldId, draw_world
from tracker.apple.segmentation import segment
from tracker.apple.single_view import measure
from tracker.apple.view import Sighting


@pytest.fixture(scope="module", params=CLASSES)
def photograph(request):
    cv2.setNumThreads(1)
    world = draw_world(WorldId(request.param, 0.9, 1000))
    with world.build() as orchard:
        return ArmPhotographer(orchard, 0)(world.approach[5])


def test_segmentation_and_attitude(benchmark, photograph):
    seen = sighting(photograph, SEGMENTED)

    def attitude():
        return measure(Sighting(segment(photograph.rgb), seen.K, seen.pose))

    found = benchmark(attitude)
    assert found is not None
    assert np.isfinite(found.axis).all()
