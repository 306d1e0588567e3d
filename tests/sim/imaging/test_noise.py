"""What the sensor adds: as much noise as declared, and the same from the same stream."""

import numpy as np
import pytest

from sim.imaging.degradations import Condition, get_condition
from sim.imaging.noise import SensorNoise, noise_std_of_level

QUIET = {"colour_noise_std": 0.0, "depth_noise_std_m": 0.0, "width_px": 16, "height_px": 16}
WHOLE = slice(None), slice(None)


def noisy(noise: SensorNoise, picture: tuple[np.ndarray, np.ndarray]) -> tuple:
    """The picture with the noise of the next image."""
    rgb, depth_m = picture
    return noise.draw().on(lambda window: (rgb[window], depth_m[window]), WHOLE)


def picture(condition: Condition, level: int = 120) -> tuple[np.ndarray, np.ndarray]:
    shape = condition.height_px, condition.width_px
    return np.full((*shape, 3), level, np.uint8), np.full(shape, 1.5, np.float32)


def test_no_noise_is_the_identity():
    quiet = Condition(**QUIET)
    rgb, depth_m = picture(quiet)
    noise = SensorNoise(quiet, np.random.default_rng(0))
    noisy_rgb, noisy_depth_m = noisy(noise, (rgb, depth_m))
    assert np.array_equal(noisy_rgb, rgb) and np.array_equal(noisy_depth_m, depth_m)


@pytest.mark.parametrize("name", ["normal", "resolution-2", "noise-2", "dark-1", "depth-1"])
@pytest.mark.parametrize("level", [40, 120])
def test_noise_keeps_shape_and_has_the_declared_size(name, level):
    condition = get_condition(name)
    rgb, depth_m = picture(condition, level)
    noise = SensorNoise(condition, np.random.default_rng(0))
    noisy_rgb, noisy_depth_m = noisy(noise, (rgb, depth_m))
    assert noisy_rgb.shape == rgb.shape and noisy_rgb.dtype == np.uint8
    assert noisy_depth_m.shape == depth_m.shape and noisy_depth_m.dtype == np.float32
    expected = noise_std_of_level(condition)[level]
    assert np.std(noisy_rgb.astype(float)) == pytest.approx(expected, rel=0.05)
    known = noisy_depth_m[noisy_depth_m > 0.0]
    assert np.std(known) == pytest.approx(condition.depth_noise_std_m, rel=0.05)
    holes = 1.0 - known.size / noisy_depth_m.size
    assert holes == pytest.approx(condition.depth_hole_share, abs=0.3 * condition.depth_hole_share)
    assert (rgb == level).all()


def test_shot_noise_grows_with_the_root_of_the_light():
    std = noise_std_of_level(Condition(colour_noise_std=0.0, full_well_e=2550.0))
    assert std[[0, 10, 40, 250]] == pytest.approx([0.0, 1.0, 2.0, 5.0])


def test_frames_differ_and_the_same_stream_repeats_them():
    condition = Condition()
    first, second = (SensorNoise(condition, np.random.default_rng(3)) for _ in range(2))
    frames = [noisy(first, picture(condition))[0] for _ in range(3)]
    again = [noisy(second, picture(condition))[0] for _ in range(3)]
    assert all(np.array_equal(a, b) for a, b in zip(frames, again, strict=True))
    assert not np.array_equal(frames[0], frames[1])


def test_noise_saturates_instead_of_wrapping():
    rgb, depth_m = picture(Condition(), 0)
    assert noisy(SensorNoise(Condition(), np.random.default_rng(0)), (rgb, depth_m))[0].max() < 20
