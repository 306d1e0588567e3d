"""The trackers to compare with: what each does, and what it says where it is not installed."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from films import BOX, STEP_PX, digest, film, follow

from tracker.base import Status
from tracker.belt.registry import get_tracker_config
from tracker.peers import baselines
from tracker.peers.baselines import BASELINES
from tracker.peers.outside import get_box_finder

HERE = Path(__file__).resolve().parents[1]
AVAILABLE = [name for name, row in BASELINES.items() if row.is_available]


@pytest.fixture
def gone():
    """An image without the card, flat."""
    return np.full((180, 240, 3), 70, np.uint8)


def test_what_needs_no_contrib_modules_is_there():
    assert {"ecc", "template", "mil"} <= set(AVAILABLE)


@pytest.mark.parametrize("name", AVAILABLE)
def test_a_moving_card_is_followed(name):
    images = film()
    before = [image.copy() for image in images]
    tracker, estimates = follow(name, images)
    assert tracker.is_found
    centre = estimates[-1].box[:2] + estimates[-1].box[2:] / 2
    true = BOX[:2] + BOX[2:] / 2 + np.multiply(10, STEP_PX)
    assert np.abs(centre - true).max() <= (6.0 if name == "tld" else 4.0)  # its detector jumps
    np.testing.assert_allclose(estimates[-1].box[2:], BOX[2:], rtol=0.25)
    np.testing.assert_array_equal(images, before)


@pytest.fixture(scope="module")
def digests_of_another_process():
    """Name -> digest with the seed 3."""
    code = (
        "import cv2, json, sys; from films import digest; cv2.setNumThreads(1); "
        "print(json.dumps({name: digest(name, 3) for name in sys.argv[1:]}))"
    )
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join([str(HERE), str(HERE.parent.parent)]))
    command = [sys.executable, "-c", code, *reversed(AVAILABLE)]
    run = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return json.loads(run.stdout)


@pytest.mark.parametrize("name", AVAILABLE)
def test_the_same_generator_gives_the_same_boxes(name, digests_of_another_process):
    assert digest(name, 3) == digest(name, 3) == digests_of_another_process[name]


@pytest.mark.parametrize("name", [name for name in AVAILABLE if not BASELINES[name].is_random])
def test_what_is_not_random_does_not_depend_on_the_seed(name):
    assert digest(name, 1) == digest(name, 2)


@pytest.mark.parametrize("name", ["ecc", "template"])
def test_the_last_box_is_held_where_nothing_is_found(name, gone):
    images = film()
    tracker, estimates = follow(name, images[:6])
    held = tracker.update(gone)
    assert not tracker.is_found
    np.testing.assert_array_equal(held.box, estimates[-1].box)
    assert held.affine is None or held.affine.status is Status.UNCERTAIN
    tracker.update(images[6])
    assert tracker.is_found


def test_alignment_gives_the_affine_warp():
    x, y, w, h = BOX
    centre = np.array([x + (w - 1) / 2, y + (h - 1) / 2])
    turn_rad, growth = math.radians(6.0), 1.05
    image = film(1)[0]
    turn = cv2.getRotationMatrix2D(centre.tolist(), -math.degrees(turn_rad), growth)
    turned = cv2.warpAffine(image, turn, image.shape[1::-1])
    _, (estimate,) = follow("ecc", [image, turned])
    warp = estimate.affine.warp
    unit = math.sqrt(w * h)
    expected = (
        unit
        * growth
        * np.array(
            [[math.cos(turn_rad), -math.sin(turn_rad)], [math.sin(turn_rad), math.cos(turn_rad)]]
        )
    )
    np.testing.assert_allclose(warp[:2, :2], expected, atol=0.03 * unit)
    np.testing.assert_allclose(warp[:2, 2], centre, atol=0.5)


@pytest.mark.parametrize("name", [name for name in AVAILABLE if name != "mil"])
@pytest.mark.parametrize(
    ("box", "reason"),
    [
        ((60, 50, 0, 32), "box must be x, y, w, h with w and h of 1 px or more"),
        ((60, 50, math.nan, 32), "box must be"),
        ((60, 50, 48), "box must be"),
        ((300, 50, 48, 32), "box must lie in the image of 240 x 180 px"),
    ],
)
def test_a_box_that_cannot_be_tracked_is_refused(name, box, reason):
    tracker = BASELINES[name].make(np.random.default_rng(0))
    with pytest.raises(ValueError, match=reason):
        tracker.start(film(1)[0], np.array(box, float))


def test_a_patch_without_texture_and_an_image_without_colour_are_refused(gone):
    tracker = BASELINES["template"].make(np.random.default_rng(0))
    with pytest.raises(ValueError, match="texture"):
        tracker.start(gone, BOX)
    with pytest.raises(ValueError, match=r"image must be uint8 \(h, w, 3\)"):
        tracker.start(gone[..., 0], BOX)
    with pytest.raises(ValueError, match="before start"):
        tracker.update(gone)


def test_a_box_over_the_border_is_cut_off():
    tracker = BASELINES["template"].make(np.random.default_rng(0))
    tracker.start(film(1)[0], np.array([-10.0, 150.0, 40.0, 60.0]))
    np.testing.assert_array_equal(tracker.box, [0, 150, 30, 30])


def test_what_is_not_installed_says_how_to_install_it(monkeypatch):
    monkeypatch.setattr(baselines, "find_in_opencv", lambda path: None)
    row = get_box_finder("csrt")
    assert not row.is_available
    with pytest.raises(ValueError, match=r"no TrackerCSRT; `make peers`") as raised:
        row.make(np.random.default_rng(0))
    assert "\n" not in str(raised.value)
    assert get_box_finder("ecc").is_available


def test_an_unknown_name_lists_the_valid_ones():
    with pytest.raises(ValueError, match=r"csrt.*template.*'goturn'"):
        get_box_finder("goturn")


@pytest.mark.parametrize("name", BASELINES)
def test_every_row_is_a_tracker_of_the_conveyor_with_one_line_about_it(name):
    assert get_tracker_config(name).baseline == name
    assert "\n" not in BASELINES[name].description
