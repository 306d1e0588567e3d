"""One synthetic scene for all tracker tests; `scenes` is importable from this folder."""

import math
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))

import scenes

from tracker.affine import aff2
from tracker.affine.template import Template
from tracker.belt.rectify import OverheadView


@pytest.fixture(scope="session", autouse=True)
def one_thread():
    cv2.setNumThreads(1)


@pytest.fixture(scope="session")
def camera():
    return scenes.far_side_camera()


@pytest.fixture(scope="session")
def view(camera):
    return OverheadView(*camera, (480, 640))


@pytest.fixture
def scene(camera):
    return scenes.Scene(*camera)


@pytest.fixture(scope="session")
def template():
    return Template.of_picture(scenes.box_picture(), scenes.SIZE_M)


@pytest.fixture(scope="session")
def unit_px(view):
    return math.sqrt(scenes.SIZE_M[0] * scenes.SIZE_M[1]) / view.m_per_px


@pytest.fixture(scope="session")
def true_warp(view, unit_px):
    """Warp of the box at (x, y, yaw) in the overhead image."""

    def warp(x, y, yaw):
        return aff2.similarity(
            unit_px, math.pi / 2 - yaw, scenes.pixel_of_world(view, np.array([x, y]))
        )

    return warp
