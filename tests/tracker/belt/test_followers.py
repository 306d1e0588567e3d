"""Baselines in the conveyor's perception: same detection, same reconstruction, another tracker."""

import math

import numpy as np
import pytest
from driving import build, drive
from films import BOX

from tracker.base import Status
from tracker.belt.detection import Detection, Sighting
from tracker.belt.followers import BoxFollower
from tracker.belt.rectify import OverheadImage
from tracker.belt.registry import StatusConfig
from tracker.box_tracker import BoxEstimate, box_of_warp
from tracker.peers.baselines import BASELINES
from tracker.peers.box_finder import HoldingTracker

AVAILABLE = [name for name, row in BASELINES.items() if row.is_available]


class Scripted:
    """A finder that finds a box where the script has one."""

    def __init__(self, shifts):
        self.shifts = iter(shifts)

    def start(self, image, box):
        self.box = box

    def find(self, image):
        shift = next(self.shifts)
        return None if shift is None else BoxEstimate(self.box + np.array([*shift, 0, 0]))


@pytest.fixture
def image(view):
    grey = np.random.default_rng(0).integers(0, 255, view.shape_px, np.uint8)
    return OverheadImage(grey, np.ones_like(grey), np.full(grey.shape, np.nan, np.float32))


@pytest.fixture
def sighting(true_warp):
    return Sighting(Detection(true_warp(0.5, 0.0, 0.4), 0.9, 1.0), 0.0)


def follow(template, image, sighting, shifts):
    follower = BoxFollower(HoldingTracker(Scripted(shifts)), template, StatusConfig())
    follower.start(image, sighting, sighting)
    return [follower.update(image, (k + 1) / 30) for k in range(len(shifts))]


@pytest.mark.parametrize("name", AVAILABLE)
def test_a_baseline_tracks_a_box_on_a_moving_belt(template, view, scene, name):
    seen, errors = drive(build(name, template, view), scene, speed=0.25, yaw=0.4, count=8)
    assert [s.status for s in seen] == [Status.SEARCHING] + [Status.TRACKING] * 7
    assert len(errors) == 7
    assert np.abs(errors[:, :2]).max() < (0.03 if name == "tld" else 0.015)
    assert np.abs(errors[:, 2]).max() < 0.003
    assert math.degrees(np.abs(errors[:, 3]).max()) < 2.0


def test_a_box_moves_the_warp_of_the_detection_by_its_centre(template, image, sighting):
    first, second = follow(template, image, sighting, [(0, 0), (7, -3)])
    np.testing.assert_allclose(first.warp, sighting.found.warp, atol=1e-9)
    moved = sighting.found.warp + np.array([[0, 0, 7], [0, 0, -3], [0, 0, 0]])
    np.testing.assert_allclose(second.warp, moved, atol=1e-9)
    assert second.status is Status.TRACKING


def test_a_visible_target_that_is_not_found_is_lost_soon(template, image, sighting):
    estimates = follow(template, image, sighting, [(1, 1), None, (2, 2), None, None, None])
    assert [e.status.value for e in estimates] == [
        "tracking", "uncertain", "tracking", "uncertain", "uncertain", "lost"
    ]  # fmt: skip


def test_a_hidden_target_that_is_not_found_is_waited_for(template, image, sighting):
    x, y, w, h = np.rint(box_of_warp(sighting.found.warp, template.size)).astype(int)
    image.visibility[max(y - 5, 0) : y + h + 5, max(x - 5, 0) : x + w + 5] = 0
    estimates = follow(template, image, sighting, [None] * 31)
    assert [e.status for e in estimates[:30]] == [Status.UNCERTAIN] * 30
    assert estimates[30].status is Status.LOST
    assert estimates[0].visible_fraction < 0.25


def test_an_image_that_shows_nothing_is_kept_from_the_baseline(template, image, sighting):
    follower = BoxFollower(HoldingTracker(Scripted([(3, 0), (5, 0)])), template, StatusConfig())
    follower.start(image, sighting, sighting)
    follower.update(image, 1 / 30)
    black = OverheadImage(image.grey * 0, image.visibility * 0, image.height_m)
    assert follower.update(black, 2 / 30).status is Status.UNCERTAIN
    after = follower.update(image, 3 / 30)
    assert after.status is Status.TRACKING
    assert after.warp[0, 2] - sighting.found.warp[0, 2] == pytest.approx(5.0)


def test_a_target_that_the_baseline_refuses_is_lost(template, image, sighting):
    image.grey[:] = BOX[0]
    (estimate,) = follow(template, image, sighting, [(0, 0)])
    assert estimate.status is Status.LOST
