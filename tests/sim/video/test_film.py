"""Images against the truth: what is rendered is where the truth says, to a part of a pixel."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from sim.imaging.camera import OffscreenRenderer
from sim.video import film
from sim.video.clip import WALL_DEPTH_M, Actor, Clip, Lighting, Moves, Shake, Swing, Trip, Wave
from sim.video.stage import CAMERA, TARGET, Stage, flex_id

STILL = Clip("nothing moves", Actor((64.0, 48.0)), noise_levels=0.0, frame_count=2)
EASY = replace(
    STILL,
    target=Actor(
        (80.0, 60.0),
        moves=Moves(
            (Swing(40.0, (6.0, 6.0)),),
            (Swing(-30.0, (6.0, 6.0)),),
            (Swing(0.4, (6.0, 6.0)),),
            (Swing(0.9, (6.0, 6.0)),),
        ),
    ),
    frame_count=4,
)


def shot(clip, seed=0):
    return list(film.shoot(clip, np.random.default_rng(seed)))


def grey(frame):
    return cv2.cvtColor(frame.pixels, cv2.COLOR_RGB2GRAY).astype(np.float32)


def similarity(a, b):
    return float(np.corrcoef(a.ravel(), b.ravel())[0, 1])


def looked_at(image, warp, size, shift_px=(0.0, 0.0)):
    """The image at template points, 40 x 30 of them across a target of this size."""
    w, h = np.array(size) / np.sqrt(np.prod(size))
    u, v = np.meshgrid(np.linspace(-0.45, 0.45, 40) * w, np.linspace(-0.45, 0.45, 30) * h)
    x, y = warp[:2] @ np.stack([u.ravel(), v.ravel(), np.ones(u.size)])
    maps = (x + shift_px[0]).astype(np.float32), (y + shift_px[1]).astype(np.float32)
    return cv2.remap(image, *maps, cv2.INTER_LINEAR)


@pytest.fixture(scope="module")
def easy():
    return shot(EASY)


def test_the_true_warp_finds_the_first_picture_again(easy):
    first = looked_at(grey(easy[0]), easy[0].truth.warp, EASY.target.size_px)
    for frame in easy[1:]:
        now = looked_at(grey(frame), frame.truth.warp, EASY.target.size_px)
        assert similarity(first, now) > 0.97


def test_half_a_pixel_beside_the_true_warp_fits_worse(easy):
    frame = easy[3]
    first = looked_at(grey(easy[0]), easy[0].truth.warp, EASY.target.size_px)
    best = similarity(first, looked_at(grey(frame), frame.truth.warp, EASY.target.size_px))
    for shift in ((0.5, 0), (-0.5, 0), (0, 0.5), (0, -0.5)):
        beside = looked_at(grey(frame), frame.truth.warp, EASY.target.size_px, shift)
        assert similarity(first, beside) < best


@pytest.mark.parametrize("shape", ["panel", "carton", "sheet"])
def test_the_rendered_target_has_the_true_corners_and_area(shape):
    turn = {"yaw_rad": (Swing(0.8, (8.0, 8.0)),), "roll_rad": (Swing(0.5, (8.0, 8.0)),)}
    bend = {"bend_rad": (Swing(1.2, (8.0, 8.0)),)} if shape == "sheet" else {}
    actor = Actor((90.0, 70.0), (140.3, 110.8), shape=shape, moves=Moves(**turn, **bend))
    stage = Stage(replace(STILL, target=actor), np.random.default_rng(0))
    surveyor = film.Surveyor(stage.target, film._target_px(stage, 0.0))
    scale = 4
    with OffscreenRenderer(stage.model, scale * 320, scale * 240) as renderer:
        for time in (0.0, 4.0):
            truth = surveyor.truth(film._target_px(stage, time))
            _, number = renderer.segment(stage.model, stage.data, CAMERA)
            rows, columns = np.nonzero(number == flex_id(stage.model, TARGET))
            xs, ys = (columns - 1.5) / scale, (rows - 1.5) / scale  # centres of a finer image
            box = truth.box
            assert [xs.min(), ys.min()] == pytest.approx(box[:2] - 0.5, abs=0.3)
            assert [xs.max(), ys.max()] == pytest.approx(box[:2] + box[2:] - 0.5, abs=0.3)
            assert len(xs) / scale**2 == pytest.approx(truth.area_px, rel=0.01)


def test_the_first_image_shows_the_target_where_the_script_puts_it(easy):
    truth = easy[0].truth
    assert truth.box == pytest.approx([159.5 - 39.5, 119.5 - 29.5, 80, 60])
    assert easy[0].visible > 0.99


def test_an_occluder_and_the_border_hide_what_they_hide():
    half = Actor((64.0, 200.0), start_px=(159.5 - 32.0, 119.5), depth_m=1.0, artwork="pole")
    assert shot(replace(STILL, others=(half,)))[0].visible == pytest.approx(0.5, abs=0.02)
    away = Actor((64.0, 48.0), moves=Moves(x_px=(Trip(300.0, 0.0, 50.0, 1.0),)))
    frames = shot(replace(STILL, target=away))
    assert frames[1].visible == 0.0
    assert frames[1].truth.box[0] == pytest.approx(frames[0].truth.box[0] + 300.0)
    edge = Actor((64.0, 48.0), start_px=(319.5, 119.5))
    assert shot(replace(STILL, target=edge))[0].visible == pytest.approx(0.5, abs=0.02)


def test_a_turning_camera_moves_the_truth():
    clip = replace(STILL, shake=Shake(pan_rad=(Trip(0.1, 0.0, 50.0, 1.0),)))
    before, after = shot(clip)
    moved_px = after.truth.warp[0, 2] - before.truth.warp[0, 2]
    assert moved_px == pytest.approx(-300.0 * np.tan(0.1), abs=0.2)
    size = clip.target.size_px
    views = [looked_at(grey(f), f.truth.warp, size) for f in (before, after)]
    assert similarity(*views) > 0.97


def test_a_long_exposure_smears_along_the_motion_about_the_truth():
    sharp = replace(
        STILL,
        target=Actor((64.0, 48.0), moves=Moves(x_px=(Trip(120.0, 0.0, 50.0, 12.0),))),
        frame_count=7,
    )
    sharp_frame, smeared = (shot(c)[6] for c in (sharp, replace(sharp, exposure_frames=1.0)))
    steep = [np.abs(np.diff(grey(f), axis=1)).mean() for f in (sharp_frame, smeared)]
    assert steep[1] < 0.97 * steep[0]
    assert np.array_equal(sharp_frame.truth.warp, smeared.truth.warp)
    first = shot(replace(sharp, exposure_frames=1.0, frame_count=2))[0]
    assert np.array_equal(first.pixels, shot(replace(sharp, frame_count=2))[0].pixels)


def test_light_changes_the_image_and_not_the_truth():
    dim = replace(STILL, lighting=Lighting(lamp_octaves=(Trip(-3.0, 0.0, 50.0, 1.0),)))
    bright, dark = shot(dim)
    assert dark.pixels.mean() < 0.75 * bright.pixels.mean()
    assert np.array_equal(bright.truth.warp, dark.truth.warp)


def test_the_same_seed_gives_the_same_frames_and_the_survey_their_truth():
    noisy = replace(EASY, noise_levels=2.0, frame_count=2)
    first, second = shot(noisy, 5), shot(noisy, 5)
    surveyed = film.survey(noisy, np.random.default_rng(5))
    for a, b, truth in zip(first, second, surveyed, strict=True):
        assert np.array_equal(a.pixels, b.pixels)
        assert np.array_equal(a.truth.warp, truth.warp)
    assert not np.array_equal(first[0].pixels, shot(noisy, 6)[0].pixels)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Actor((64.0, 4.0)), "size_px must be at least 8"),
        (lambda: Actor((64.0, 48.0), depth_m=WALL_DEPTH_M), "depth_m must lie between"),
        (lambda: replace(STILL, frame_count=1), "frame_count must be 2 or greater, got 1"),
        (
            lambda: replace(STILL, exposure_frames=1.5),
            "exposure_frames must be a number from 0 to 1",
        ),
        (lambda: replace(STILL, noise_levels=-1.0), "noise_levels must be 0 or greater, got -1"),
    ],
)
def test_an_impossible_clip_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_a_wave_in_a_clip_is_drawn_from_its_generator():
    moving = replace(STILL, target=Actor((64.0, 48.0), moves=Moves((Wave(40.0, (20, 40)),))))
    paths = [[t.box[0] for t in film.survey(moving, np.random.default_rng(s))] for s in (0, 0, 1)]
    assert paths[0] == paths[1] != paths[2]
