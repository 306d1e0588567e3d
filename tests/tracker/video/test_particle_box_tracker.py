from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import videos

from tracker.affine import aff2
from tracker.base import Status
from tracker.box_tracker import box_of_warp, warp_of_box
from tracker.video.appearance import AppearanceConfig
from tracker.video.particle_box_tracker import ParticleBoxTracker
from tracker.video.redetection import RedetectionConfig
from tracker.video.registry import BOX_TRACKERS

BOX = np.array([60.0, 50.0, *videos.SIZE_PX])


def drifting(count, e):
    """Warps that start upright on BOX and move by the tangent vector e each image."""
    start = warp_of_box(BOX)
    return [aff2.perturb(start, k * np.array(e)) for k in range(count)]


def small(name, **changes):
    config = BOX_TRACKERS[name]
    return replace(config, filter=replace(config.filter, particle_count=60), **changes)


def looking(config, **changes):
    return replace(config, appearance=replace(config.appearance, **changes))


def calm(name):
    """For a target that moves as little as in most images: less noise, sharper pictures."""
    config = looking(small(name), blurs=(0.06,))
    noise = (*config.filter.noise_per_root_s[:4], 0.08, 0.08)
    return replace(config, filter=replace(config.filter, noise_per_root_s=noise))


def follow(name, images, seed=0, box=BOX, config=None):
    tracker = ParticleBoxTracker(config or small(name), np.random.default_rng(seed))
    tracker.start(images[0], box)
    return [tracker.update(image) for image in images[1:]]


def test_box_and_warp_of_an_upright_target_agree():
    warp = warp_of_box(BOX)
    unit = np.sqrt(BOX[2] * BOX[3])
    np.testing.assert_allclose(box_of_warp(warp, (BOX[2] / unit, BOX[3] / unit)), BOX)


@pytest.mark.parametrize("name", BOX_TRACKERS)
def test_a_turning_and_growing_target_is_followed(name):
    warps = drifting(12, [0.01, 0, 0.02, 0, 0.03, 0.02])
    estimates = follow(name, videos.film(warps), config=calm(name))
    error = aff2.difference(warps[-1], estimates[-1].affine.warp)
    assert np.hypot(*error[4:]) < 0.06
    assert abs(error[0]) < 0.06
    assert abs(error[2]) < 0.08
    assert estimates[-1].affine.status == "tracking"


@pytest.mark.parametrize("name", BOX_TRACKERS)
def test_same_seed_same_boxes(name):
    images = videos.film(drifting(5, [0, 0, 0, 0, 0.05, 0]))
    first, second = (np.array([e.box for e in follow(name, images, seed=3)]) for _ in range(2))
    np.testing.assert_array_equal(first, second)


def test_the_guide_finds_a_target_that_jumped():
    """By more than half its width: no particle of the template alone goes there."""
    warps = drifting(12, [0, 0, 0, 0, 0.01, 0])
    jump = np.array([[0, 0, 28], [0, 0, 12], [0, 0, 0]])
    warps[6:] = [X + jump for X in warps[6:]]
    images = videos.film(warps)
    guided, alone = (follow(n, images)[-1].affine.warp[:2, 2] for n in ("igpf-best", "igpf"))
    assert np.linalg.norm(guided - warps[-1][:2, 2]) < 4
    assert np.linalg.norm(alone - warps[-1][:2, 2]) > 10


def test_an_anchored_template_forgets_what_it_has_learnt():
    """A target that is shown another way for a while, and then as at first."""
    steady = drifting(30, np.zeros(6))
    images = videos.film(steady[:10]) + videos.film(steady[:20], seed=0, noise=40.0)
    images += videos.film(steady[:1])
    ncc = {}
    for anchor in (0.0, 1.0):
        config = looking(small("igpf"), anchor=anchor, update_rate=0.5, update_ncc=0.0)
        tracker = ParticleBoxTracker(config, np.random.default_rng(0))
        tracker.start(images[0], BOX)
        ncc[anchor] = [tracker.update(image).affine.ncc for image in images[1:]][-1]
    assert ncc[1.0] > ncc[0.0]


def test_a_target_that_leaves_the_image_breaks_nothing():
    warps = drifting(14, [0, 0, 0, 0, -0.4, 0])
    for name in BOX_TRACKERS:
        assert all(np.isfinite(e.box).all() for e in follow(name, videos.film(warps)))


@pytest.mark.parametrize(
    ("box", "message"),
    [([60, 50, 0, 30], "area"), ([60, 50, np.nan, 30], "area"), ([60, 50, 40, -1], "area")],
)
def test_boxes_without_area_are_refused(box, message):
    image = videos.film(drifting(1, np.zeros(6)))[0]
    with pytest.raises(ValueError, match=message):
        ParticleBoxTracker(small("igpf"), np.random.default_rng(0)).start(image, np.array(box))


def test_a_constant_patch_is_refused():
    with pytest.raises(ValueError, match="texture"):
        ParticleBoxTracker(small("igpf"), np.random.default_rng(0)).start(
            np.full((180, 240, 3), 90, np.uint8), BOX
        )


def test_a_collector_gets_the_particles_before_and_after_each_resampling():
    images = videos.film(drifting(4, [0, 0, 0, 0, 0.02, 0]))
    for name in BOX_TRACKERS:
        tracker = ParticleBoxTracker(small(name), np.random.default_rng(0))
        resamplings = []
        tracker.collect_resamplings(lambda *pair, found=resamplings: found.append(pair))
        tracker.start(images[0], BOX)
        for image in images[1:]:
            estimate = tracker.update(image).affine
        assert len(resamplings) == len(images) - 1
        before, after = resamplings[-1]
        assert before.weights.sum() == pytest.approx(1.0)
        np.testing.assert_array_equal(after.warps, estimate.particles)
        if name in ("gpf", "pf"):
            np.testing.assert_array_equal(before.warps[after.parents], after.warps)


@pytest.mark.slow
def test_ten_thousand_images_need_no_more_memory_than_a_thousand():
    images = videos.film(drifting(20, [0, 0, 0, 0, 0.01, 0]))
    images += images[::-1]
    tracker = ParticleBoxTracker(small("igpf"), np.random.default_rng(0))
    tracker.start(images[0], BOX)
    resident_kib = []
    for k in range(10_000):
        tracker.update(images[k % len(images)])
        if k % 1000 == 999:
            resident_kib.append(int(Path("/proc/self/statm").read_text().split()[1]) * 4)
    assert max(resident_kib[1:]) - resident_kib[0] < 1024


def test_update_before_start_is_refused():
    with pytest.raises(ValueError, match="start"):
        ParticleBoxTracker(small("igpf"), np.random.default_rng(0)).update(np.zeros((9, 9, 3)))


def test_a_target_that_was_carried_away_is_found_again_only_by_looking_for_it():
    """Cut from one corner of the image to another, where nothing of the window reaches.

    The picture is hardly smoothed, so that little of the old surroundings is in the template.
    """
    here = drifting(8, [0, 0, 0, 0, 0.01, 0])
    there = [X + np.array([[0, 0, 100], [0, 0, 80], [0, 0, 0]]) for X in here]
    images = videos.film(here + 2 * there)
    statuses = {}
    looks_for_it = RedetectionConfig(missed_share=0.8, found_share=0.8)
    for redetection in (None, looks_for_it):
        row = small("igpf", redetection=redetection)
        config = looking(row, blurs=(0.02,), update_ncc=0.8)
        estimates = follow("igpf", images, config=config)
        error_px = np.linalg.norm(estimates[-1].affine.warp[:2, 2] - there[-1][:2, 2])
        assert (error_px < 4) == (redetection is not None)
        statuses[redetection] = [estimate.affine.status for estimate in estimates]
    assert Status.LOST not in statuses[None]
    assert Status.LOST in statuses[looks_for_it]
    assert statuses[looks_for_it][-1] == Status.TRACKING


def test_what_hides_the_target_teaches_nothing():
    """It is covered where it stands for a while, and comes out elsewhere."""
    here, there = drifting(1, np.zeros(6))[0], drifting(1, np.zeros(6))[0]
    there[:2, 2] += (90.0, 60.0)
    images = videos.film([here] * 6 + [there] * 24)
    cover = np.random.default_rng(5).integers(0, 255, (12, 16, 3)).astype(np.uint8)
    for image in images[6:]:
        image[40:100, 50:130] = np.repeat(np.repeat(cover, 5, axis=0), 5, axis=1)
    for image in images[6:18]:
        image[100:170, 130:230] = 90
    error_px = {}
    for redetection in (None, RedetectionConfig()):
        config = small("igpf-best", redetection=redetection)
        estimates = follow("igpf-best", images, config=config)
        error_px[redetection] = np.linalg.norm(estimates[-1].affine.warp[:2, 2] - there[:2, 2])
    assert error_px[RedetectionConfig()] < 1 < 60 < error_px[None]
    statuses = [estimate.affine.status for estimate in estimates]
    assert statuses[3] == statuses[-1] == Status.TRACKING
    assert statuses[14] == Status.LOST


def test_a_coarse_first_level_reaches_farther_than_the_fine_one_alone():
    """By a sixth of the target's side in one image."""
    start = drifting(1, np.zeros(6))[0]
    jump = aff2.perturb(start, np.array([0, 0, 0, 0, 0.15, 0.1]))
    images = videos.film([start, jump])
    errors = {}
    for blurs in ((0.03, 0.03), (0.25, 0.03)):
        row = small("gpf")
        noise = (0.01, 0.005, 0.01, 0.005, 0.2, 0.2)
        faster = replace(row.filter, iterations=2, noise_per_root_s=noise)
        config = looking(replace(row, filter=faster), blurs=blurs)
        estimate = follow("gpf", images, config=config)[-1]
        errors[blurs[0]] = np.linalg.norm(aff2.difference(jump, estimate.affine.warp)[4:])
    assert errors[0.25] < 0.5 * errors[0.03]


def test_families_follow_the_target_too():
    row = calm("igpf")
    config = replace(row, filter=replace(row.filter, family_size=5))
    warps = drifting(12, [0.01, 0, 0.01, 0, 0.03, 0.02])
    error = aff2.difference(
        warps[-1], follow("igpf", videos.film(warps), config=config)[-1].affine.warp
    )
    assert np.hypot(*error[4:]) < 0.06


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"reach": np.inf}, "reach"),
        ({"tracking_ncc": -0.1}, "tracking_ncc"),
        ({"appearance": AppearanceConfig(blurs=(0.2, 0.1))}, "2 blurs need as many iterations"),
    ],
)
def test_bad_settings_are_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        replace(BOX_TRACKERS["igpf"], **changes)
