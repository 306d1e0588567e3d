"""Tracker step, detection and rectification on one synthetic 640 x 480 RGB-D image."""

import importlib.util
import math
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from tracker.affine.template import Template
from tracker.belt.detection import DetectionConfig, TemplateDetector
from tracker.belt.image import ArrayImage
from tracker.belt.perception import TargetTracker
from tracker.belt.rectify import OverheadView
from tracker.belt.registry import get_tracker_config

SCENES = Path(__file__).parents[1] / "tests" / "tracker" / "scenes.py"


@pytest.fixture(scope="module")
def scenes():
    spec = importlib.util.spec_from_file_location("scenes", SCENES)
    module = importlib.util.module_from_spec(spec)
    sys.modules["scenes"] = module
    spec.loader.exec_module(module)
    cv2.setNumThreads(1)
    return module


@pytest.fixture(scope="module")
def image(scenes):
    return scenes.Scene(*scenes.far_side_camera()).render(0.53, 0.0, 0.4)


@pytest.fixture(scope="module")
def view(scenes):
    return OverheadView(*scenes.far_side_camera(), (480, 640))


@pytest.fixture(scope="module")
def template(scenes):
    return Template.of_picture(scenes.box_picture(), scenes.SIZE_M)


@pytest.mark.parametrize("name", ["igpf", "gpf", "pf"])
def test_update_in_steady_state(benchmark, scenes, image, view, template, name):
    rng = np.random.default_rng(0)
    tracker = TargetTracker(get_tracker_config(name), template, scenes.SIZE_M, view, rng)
    times = iter(np.arange(100000) / 30.0)
    for _ in range(4):
        tracker.update(ArrayImage(*image, next(times)))
    observation = benchmark(lambda: tracker.update(ArrayImage(*image, next(times))))
    assert observation.status == "tracking"


def test_detection(benchmark, scenes, image, view, template):
    unit_px = math.sqrt(math.prod(scenes.SIZE_M)) / view.m_per_px
    detector = TemplateDetector(template, unit_px, view.shape_px, DetectionConfig())
    overhead = view.rectify(ArrayImage(*image))
    assert benchmark(detector.detect, overhead.grey, overhead.visibility) is not None


def test_rectification(benchmark, image, view):
    benchmark(view.rectify, ArrayImage(*image))
