"""What the trackers are shown of the object before any trial."""

import cv2
import numpy as np
import pytest

from experiments.belt import teaching
from experiments.belt.cell import make_cell
from experiments.belt.config import TrialConfig


def picture(condition: str) -> np.ndarray:
    cell = make_cell(TrialConfig(condition=condition), has_camera=True)
    return teaching.reference_picture(cell.task, cell.environment.physics)


@pytest.fixture(scope="module")
def sharp() -> np.ndarray:
    return picture("normal")


def test_picture_is_the_face_alone_at_the_stated_scale(sharp):
    assert sharp.shape == (81, 201) and sharp.dtype == np.uint8
    assert sharp.std() > 30.0


def test_coarse_picture_is_the_mean_of_what_each_pixel_covers(sharp, monkeypatch):
    """Pixels of 15 mm: shifting the object brings out more than one image of it shows."""
    inside = slice(15, -15), slice(15, -15)
    expected = cv2.GaussianBlur(sharp, (0, 0), 7.0)[inside]
    many = picture("resolution-2")
    monkeypatch.setattr(teaching, "SHIFTS", 1)
    single = picture("resolution-2")
    alike = [np.corrcoef(expected.ravel(), p[inside].ravel())[0, 1] for p in (many, single)]
    assert alike[0] > 0.95
    assert alike[0] > alike[1]


def test_picture_does_not_show_where_the_last_trial_left_the_belt(sharp):
    cell = make_cell(TrialConfig(), has_camera=True)
    cell.environment.reset()
    for _ in range(5):
        cell.environment.step(np.array([*cell.task.robot.q(cell.environment.physics), *[0.0] * 7]))
    assert np.array_equal(picture("normal"), sharp)


def test_template_is_that_of_the_condition_whatever_was_tried_before():
    """One cell serves many conditions; a row must not depend on the order of the trials."""
    shaded = make_cell(TrialConfig(condition="shadows-1"), has_camera=True).template
    plain = make_cell(TrialConfig(), has_camera=True).template
    assert plain is not shaded
    assert np.array_equal(plain.picture, picture("normal"))


def test_picture_does_not_show_where_the_belt_stopped(sharp):
    """At the edges of the face a pixel sees some of the belt, whose drawing moves."""
    cell = make_cell(TrialConfig(), has_camera=True)
    cell.environment.reset()
    q = cell.task.robot.q(cell.environment.physics)
    for _ in range(20):
        cell.environment.step(np.concatenate([q, np.zeros(6), [0.11]]))
    assert np.array_equal(picture("normal"), sharp)
