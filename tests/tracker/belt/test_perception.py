"""The whole path from RGB-D images to poses, on a synthetic belt."""

import math
from dataclasses import replace

import numpy as np
import pytest
from driving import RATE_HZ, build, drive
from scenes import TOP_Z_M, Scene, pixel_of_world

from tracker.base import Status
from tracker.belt.followers import FilterFollower
from tracker.belt.image import ArrayImage
from tracker.belt.perception import TargetTracker
from tracker.belt.registry import get_tracker_config


@pytest.mark.parametrize(
    ("name", "position_m", "yaw_deg"), [("igpf", 1e-3, 0.5), ("gpf", 1e-3, 0.5), ("pf", 3e-3, 3.0)]
)
@pytest.mark.parametrize(("speed", "yaw"), [(0.25, 0.4), (1.25, -2.0)])
def test_tracks_a_box_on_a_moving_belt(
    template, view, scene, name, position_m, yaw_deg, speed, yaw
):
    seen, errors = drive(build(name, template, view), scene, speed, yaw, 16)
    assert seen[0].status is Status.SEARCHING
    assert [s.status for s in seen[1:]] == [Status.TRACKING] * 15
    rms = np.sqrt((errors**2).mean(axis=0))
    assert rms[:3].max() < position_m
    assert math.degrees(rms[3]) < yaw_deg


@pytest.mark.parametrize("name", ["igpf", "pf"])
def test_sees_all_it_needs_in_the_window_that_it_asks_for(
    template, view, camera, name, monkeypatch
):
    cropped = drive(build(name, template, view), Scene(*camera), 0.6, 0.9, 12)[1]
    monkeypatch.setattr(FilterFollower, "region", lambda self, time_s: None)
    whole = drive(build(name, template, view), Scene(*camera), 0.6, 0.9, 12)[1]
    np.testing.assert_array_equal(cropped, whole)


def test_a_tracked_target_needs_a_small_part_of_the_image(template, view, scene):
    tracker, shares = build("igpf", template, view), []
    for k in range(8):
        image = ArrayImage(*scene.render(0.53, -0.3 + 0.02 * k, 0.4), k / RATE_HZ)
        crop = image.crop

        def watched(window, crop=crop):
            rgb, depth_m = crop(window)
            shares.append(rgb[..., 0].size / (640 * 480))
            return rgb, depth_m

        object.__setattr__(image, "crop", watched)
        tracker.update(image)
    assert min(shares[:2]) > 2 * np.median(shares[2:]) and np.median(shares[2:]) < 0.12


def test_survives_dim_light(template, view, scene):
    scene.light = 0.3
    _, errors = drive(build("igpf", template, view), scene, 0.5, 1.0, 12)
    assert len(errors) == 11
    assert np.abs(errors[:, :3]).max() < 2e-3


def test_a_hand_over_half_the_box_does_not_pull_the_pose(template, view, scene):
    def hand(k, y):
        return None if k < 5 else (0.5, 0.72, y - 0.1, y + 0.01, 0.2)

    seen, errors = drive(build("igpf", template, view), scene, 0.25, 1.57, 16, occluder=hand)
    assert min(s.estimate.visible_fraction for s in seen[6:]) < 0.75
    assert np.abs(errors[:, :2]).max() < 5e-3
    assert np.degrees(np.abs(errors[:, 3])).max() < 2.0


def test_a_hidden_box_is_coasted_then_found_again(template, view, scene):
    tracker = build("igpf", template, view)

    def cover(k, y):
        return (0.2, 0.95, y - 0.3, y + 0.3, 0.12) if 6 <= k < 12 else None

    seen, errors = drive(tracker, scene, 0.3, 0.4, 18, occluder=cover)
    assert all(s.status is Status.UNCERTAIN for s in seen[6:12])
    assert not any(s.pose.is_usable for s in seen[6:12])
    assert seen[-1].status is Status.TRACKING
    assert np.abs(errors[-1, :2]).max() < 2e-3


def test_a_box_that_is_gone_is_lost_and_a_new_one_is_found(template, view, scene):
    tracker = build("igpf", template, view)
    drive(tracker, scene, 0.3, 0.4, 5)
    statuses = []
    for k in range(5, 12):
        image = scene.render(0.53, 0.0, 0.4, with_box=False)
        statuses.append(tracker.update(ArrayImage(*image, k / RATE_HZ)).status)
    assert Status.TRACKING not in statuses
    assert statuses[-1] is Status.SEARCHING
    for k in range(12, 16):
        observation = tracker.update(ArrayImage(*scene.render(0.45, 0.2, -1.0), k / RATE_HZ))
    assert observation.status is Status.TRACKING
    np.testing.assert_allclose(observation.pose.position_m[:2], [0.45, 0.2], atol=2e-3)


def test_a_box_that_leaves_the_view_is_lost(template, view, scene):
    seen, _ = drive(build("igpf", template, view), scene, 1.2, 1.57, 24, y=0.4)
    assert Status.LOST in [s.status for s in seen]


@pytest.mark.parametrize("name", ["igpf", "pf"])
def test_unusable_images_make_it_uncertain_never_crash(template, view, scene, name):
    rgb, depth = scene.render(0.53, 0.0, 0.4)
    bad = [
        (np.zeros_like(rgb), depth),
        (np.empty((0, 0, 3), np.uint8), depth),
        (rgb[:100], depth),
        (rgb.astype(float) * np.nan, depth),
        (rgb[..., 0:2], depth),
        (None, None),
    ]
    for image in bad:
        tracker = build(name, template, view, particle_count=40)
        for k in range(3):
            tracker.update(ArrayImage(rgb, depth, k / RATE_HZ))
        observation = tracker.update(ArrayImage(*image, 3 / RATE_HZ))
        assert observation.status is Status.UNCERTAIN
        assert observation.pose is None or not observation.pose.is_usable
        assert tracker.update(ArrayImage(rgb, depth, 4 / RATE_HZ)).status is Status.TRACKING


def test_unusable_depth_is_done_without(template, view, scene):
    rgb, depth = scene.render(0.53, 0.0, 0.4)
    for bad in (None, np.zeros_like(depth), np.full_like(depth, np.nan), depth[:10]):
        tracker = build("igpf", template, view, particle_count=40)
        for k in range(3):
            observation = tracker.update(ArrayImage(rgb, bad, k / RATE_HZ))
        assert observation.status is Status.TRACKING
        np.testing.assert_allclose(observation.pose.position_m, [0.53, 0, TOP_Z_M], atol=2e-3)


@pytest.mark.parametrize("time_s", [math.nan, 0.05, -1.0, math.inf])
def test_a_time_that_does_not_grow_changes_nothing(template, view, scene, time_s):
    tracker = build("igpf", template, view, particle_count=40)
    rgb, depth = scene.render(0.53, 0.0, 0.4)
    for k in range(3):
        tracker.update(ArrayImage(rgb, depth, k / RATE_HZ))
    assert tracker.update(ArrayImage(rgb, depth, time_s)).status is Status.UNCERTAIN
    assert tracker.update(ArrayImage(rgb, depth, 0.2)).status is Status.TRACKING


@pytest.mark.parametrize("name", ["igpf", "gpf", "pf"])
def test_same_seed_same_poses_and_input_untouched(template, view, camera, name):
    runs = []
    for _ in range(2):
        scene, tracker = Scene(*camera), build(name, template, view, seed=7, particle_count=50)
        poses = []
        for k in range(5):
            rgb, depth = scene.render(0.5, 0.01 * k, 0.2)
            before = rgb.copy(), depth.copy()
            observation = tracker.update(ArrayImage(rgb, depth, k / RATE_HZ))
            np.testing.assert_array_equal(rgb, before[0])
            np.testing.assert_array_equal(depth, before[1])
            if observation.pose is not None:
                poses.append(observation.pose.position_m)
        runs.append(poses)
    np.testing.assert_array_equal(runs[0], runs[1])


def test_static_holds_the_first_sight(template, view, scene):
    seen, _ = drive(build("static", template, view), scene, 0.5, 0.4, 5)
    assert seen[-1].pose.position_m[1] == pytest.approx(seen[1].pose.position_m[1], abs=1e-3)


def test_drawings_lie_on_the_box_in_the_camera_image(template, view, scene):
    seen, _ = drive(build("igpf", template, view), scene, 0.25, 0.4, 4, y=0.0)
    last = seen[-1]
    assert last.corners_px.shape == (4, 2)
    x, y = 0.53, 0.25 * 3 / RATE_HZ
    q = scene.K @ np.linalg.inv(scene.T_world_camera)[:3] @ [x, y, TOP_Z_M, 1.0]
    np.testing.assert_allclose(last.particles_px.mean(axis=0), q[:2] / q[2], atol=2.0)


@pytest.mark.parametrize("size", [(0.2,), (0.2, -0.08), (math.nan, 0.08)])
def test_impossible_sizes_are_refused(template, view, size):
    with pytest.raises(ValueError, match="size_m"):
        TargetTracker(get_tracker_config("pf"), template, size, view, np.random.default_rng(0))


def drive_from_a_false_start(tracker, scene, monkeypatch):
    """As if the first two detections were 65 mm ahead; observations and errors along the belt."""
    detect, calls = tracker._detector.detect, []

    def false_at_first(*image):
        calls.append(len(seen))
        found = detect(*image)
        if found is None or len(calls) > 2:
            return found
        shift_px = 0.065 / tracker._view.m_per_px
        return replace(found, warp=np.add(found.warp, [[0, 0, shift_px], [0, 0, 0], [0, 0, 0]]))

    monkeypatch.setattr(tracker._detector, "detect", false_at_first)
    status = replace(tracker._config.status, tracking_ncc=0.0, lost_ncc=0.0)
    monkeypatch.setattr(tracker._follower, "_status_config", status)
    seen, errors = [], []
    for k in range(12):
        y_k = -0.6 + 0.3 * k / RATE_HZ
        seen.append(tracker.update(ArrayImage(*scene.render(0.53, y_k, 1.57), k / RATE_HZ)))
        pose = seen[-1].pose
        errors.append(np.nan if pose is None else pose.position_m[1] - y_k)
    return seen, np.array(errors)


def test_a_false_start_is_corrected_once_the_target_is_clear_of_the_border(
    template, view, scene, monkeypatch
):
    tracker = build("igpf", template, view)
    seen, errors = drive_from_a_false_start(tracker, scene, monkeypatch)
    (corrected,) = np.flatnonzero([observation.is_correction for observation in seen])
    assert corrected <= 6 and seen[corrected - 1].status is Status.SEARCHING
    assert np.abs(errors[corrected:]).max() < 2e-3


def test_a_confirmed_track_is_not_questioned_again(template, view, scene, monkeypatch):
    tracker, asked = build("igpf", template, view), []
    detect = tracker._detector.detect
    monkeypatch.setattr(
        tracker._detector, "detect", lambda *image: asked.append(image) or detect(*image)
    )
    seen, _ = drive(tracker, scene, 0.3, 0.4, 20)
    assert len(asked) == 3  # two sightings and one confirmation
    assert not any(observation.is_correction for observation in seen)


def test_near_the_border_nothing_is_confirmed(template, view, true_warp):
    """The box is 0.10 m long to each side, and there is to be half of that more."""
    tracker = build("igpf", template, view)
    q = view.camera_of_pixel(pixel_of_world(view, np.array([[0.57, -0.9], [0.57, -0.7]])))
    end_y = -0.9 + 0.2 * -q[0, 0] / (q[1, 0] - q[0, 0])  # where the image ends, at the far corner
    assert tracker._is_clear(true_warp(0.53, end_y + 0.17, 1.57))
    assert not tracker._is_clear(true_warp(0.53, end_y + 0.13, 1.57))
