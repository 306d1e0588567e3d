"""Conditions: nothing at zero, declared statistics otherwise."""

import numpy as np
import pytest

from sim.degradations import CONDITIONS, Condition, SensorNoise, get_condition

QUIET = Condition("no noise", colour_noise_std=0.0, depth_noise_std_m=0.0)


def picture(condition: Condition) -> tuple[np.ndarray, np.ndarray]:
    shape = condition.height_px, condition.width_px
    return np.full((*shape, 3), 120, np.uint8), np.full(shape, 1.5, np.float32)


def test_no_noise_is_the_identity():
    rgb, depth_m = picture(QUIET)
    noisy_rgb, noisy_depth_m = SensorNoise(QUIET, np.random.default_rng(0)).on(rgb, depth_m)
    assert np.array_equal(noisy_rgb, rgb)
    assert np.array_equal(noisy_depth_m, depth_m)


@pytest.mark.parametrize("name", CONDITIONS)
def test_noise_keeps_shape_and_has_the_declared_size(name):
    condition = CONDITIONS[name]
    rgb, depth_m = picture(condition)
    noisy_rgb, noisy_depth_m = SensorNoise(condition, np.random.default_rng(0)).on(rgb, depth_m)
    assert noisy_rgb.shape == rgb.shape and noisy_rgb.dtype == np.uint8
    assert noisy_depth_m.shape == depth_m.shape and noisy_depth_m.dtype == np.float32
    assert np.std(noisy_rgb.astype(float)) == pytest.approx(condition.colour_noise_std, rel=0.05)
    assert np.std(noisy_depth_m) == pytest.approx(condition.depth_noise_std_m, rel=0.05)
    assert (rgb == 120).all()


def test_frames_differ_and_the_same_stream_repeats_them():
    condition = CONDITIONS["normal"]
    first, second = (SensorNoise(condition, np.random.default_rng(3)) for _ in range(2))
    frames = [first.on(*picture(condition))[0] for _ in range(3)]
    again = [second.on(*picture(condition))[0] for _ in range(3)]
    assert all(np.array_equal(a, b) for a, b in zip(frames, again, strict=True))
    assert not np.array_equal(frames[0], frames[1])


def test_noise_saturates_instead_of_wrapping():
    condition = CONDITIONS["normal"]
    _, depth_m = picture(condition)
    black = np.zeros((condition.height_px, condition.width_px, 3), np.uint8)
    assert SensorNoise(condition, np.random.default_rng(0)).on(black, depth_m)[0].max() < 20


def test_bad_conditions_are_refused():
    with pytest.raises(ValueError, match="light_scale"):
        Condition("too bright", light_scale=3.0)
    with pytest.raises(ValueError, match="width_px"):
        Condition("no picture", width_px=0)
    with pytest.raises(ValueError, match="must be one of normal, shadows"):
        get_condition("darkness")
