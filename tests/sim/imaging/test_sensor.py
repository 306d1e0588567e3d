"""The stream of images: rate, delay, exposure, losses and noise as declared."""

import numpy as np
import pytest

from sim.imaging.camera import CAMERAS
from sim.imaging.degradations import Condition, get_condition
from sim.imaging.sensor import Develop, Sensor, SensorNoise, noise_std_of_level

TICK_HZ = 480
QUIET = {"colour_noise_std": 0.0, "depth_noise_std_m": 0.0, "width_px": 16, "height_px": 16}


class Clock:
    """Ticks for a sensor, and pictures that show the time: level and depth are the tick."""

    def __init__(self, condition: Condition, *, rate_hz=30.0, delay_s=0.05, seed=0) -> None:
        rng = np.random.default_rng(seed)
        self.sensor = Sensor(condition, rate_hz, delay_s, TICK_HZ, rng)
        self.shape = condition.height_px, condition.width_px
        self.exposed: list[int] = []

    def run(self, ticks: int) -> dict[int, tuple[int, float, int, float]]:
        """Count of each image -> tick of arrival, exposure [s], level, depth."""
        arrivals = {}
        for tick in range(ticks):
            time_s = tick / TICK_HZ
            self.sensor.look(time_s, lambda tick=tick: self._expose(tick))
            self.sensor.look(time_s, lambda: pytest.fail("exposed twice"))
            image = self.sensor.newest(time_s)
            rgb, depth_m = image.whole
            seen = tick, image.time_s, int(rgb[0, 0, 0]), float(depth_m[0, 0])
            arrivals.setdefault(image.count, seen)
        return arrivals

    def _expose(self, tick: int) -> Develop:
        self.exposed.append(tick)
        level = np.full((*self.shape, 3), tick % 256, np.uint8)
        depth_m = np.full(self.shape, float(tick), np.float32)
        return lambda window: (level[window], depth_m[window])


def test_images_come_at_the_rate_and_late_by_the_delay():
    arrivals = Clock(Condition(**QUIET)).run(200)
    assert arrivals.pop(0) == (0, 0.0, 0, 0.0)
    for count, (tick, time_s, level, depth_m) in arrivals.items():
        exposed = 16 * (count - 1)
        assert (tick, time_s, level, depth_m) == (exposed + 24, exposed / 480, exposed, exposed)


def test_long_exposure_shows_the_mean_and_is_timed_by_its_middle():
    clock = Clock(Condition(**QUIET, exposure_s=4 / 480))
    arrivals = clock.run(60)
    assert clock.exposed[:8] == [0, 1, 2, 3, 16, 17, 18, 19]
    assert arrivals[2] == (17.5 + 24.5, 17.5 / 480, 18, 18.0)


def test_shutter_closes_before_the_next_exposure():
    clock = Clock(Condition(**QUIET, exposure_s=1.0), rate_hz=60.0)
    clock.run(24)
    assert clock.exposed == list(range(24))


def test_dropped_images_are_missing_and_not_exposed():
    clock = Clock(Condition(**QUIET, dropped_share=0.5), delay_s=0.0)
    arrivals = clock.run(16 * 400)
    assert len(clock.exposed) == sum(count > 0 for count in arrivals)
    assert len(clock.exposed) == pytest.approx(200, abs=40)
    assert all(
        level == 16 * (count - 1) % 256 for count, (_, _, level, _) in arrivals.items() if count
    )


def test_late_images_are_late_and_none_overtakes():
    clock = Clock(Condition(**QUIET, late_share=0.2, late_s=4 / 30))
    arrivals = clock.run(16 * 300)
    ages = np.array(
        [tick / 480 - time_s for count, (tick, time_s, *_) in arrivals.items() if count]
    )
    assert ages.min() == pytest.approx(0.05) and ages.max() == pytest.approx(
        0.05 + 4 / 30, abs=3e-3
    )
    assert list(arrivals) == sorted(arrivals)
    assert np.mean(ages > 0.051) > 0.2


@pytest.mark.parametrize("name", ["normal", "dark-1", "depth-3+blur-1", "kinect-1"])
def test_parts_of_an_image_are_parts_of_the_whole(name):
    condition = get_condition(name)
    rng = np.random.default_rng(0)
    rgb = rng.integers(0, 256, (condition.height_px, condition.width_px, 3), np.uint8)
    column = np.arange(condition.width_px, dtype=np.float32)
    row = 1.5 + 1e-3 * column + 0.2 * (column > 350)
    depth_m = np.tile(row, (condition.height_px, 1)).astype(np.float32)
    K = CAMERAS["kinect"].intrinsics(condition.width_px, condition.height_px)
    sensor = Sensor(condition, 30.0, 0.0, TICK_HZ, np.random.default_rng(1), K)
    for tick in range(17):
        sensor.look(tick / TICK_HZ, lambda: lambda window: (rgb[window], depth_m[window]))
    image = sensor.newest(16 / TICK_HZ)
    window = slice(100, 140), slice(300, 420)
    (rgb_part, depth_part), (rgb_whole, depth_whole) = image.crop(window), image.whole
    assert np.array_equal(rgb_part, rgb_whole[window])
    np.testing.assert_allclose(depth_part, depth_whole[window], rtol=1e-6)
    assert image.whole[0].shape[:2] == image.shape_px


def test_losses_leave_the_noise_alone():
    """So that a trial with dropped images is paired with the one without."""
    streams = [np.random.default_rng(3) for _ in range(2)]
    conditions = Condition(), Condition(dropped_share=0.5)
    for condition, rng in zip(conditions, streams, strict=True):
        Sensor(condition, 30.0, 0.05, TICK_HZ, rng)
    assert streams[0].random() == streams[1].random()


WHOLE = slice(None), slice(None)


def noisy(noise: SensorNoise, picture: tuple[np.ndarray, np.ndarray]) -> tuple:
    """The picture with the noise of the next image."""
    rgb, depth_m = picture
    return noise.draw()(lambda window: (rgb[window], depth_m[window]), WHOLE)


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


def test_images_differ_and_the_same_stream_repeats_them():
    condition = Condition()
    first, second = (SensorNoise(condition, np.random.default_rng(3)) for _ in range(2))
    images = [noisy(first, picture(condition))[0] for _ in range(3)]
    again = [noisy(second, picture(condition))[0] for _ in range(3)]
    assert all(np.array_equal(a, b) for a, b in zip(images, again, strict=True))
    assert not np.array_equal(images[0], images[1])


def test_noise_saturates_instead_of_wrapping():
    rgb, depth_m = picture(Condition(), 0)
    assert noisy(SensorNoise(Condition(), np.random.default_rng(0)), (rgb, depth_m))[0].max() < 20
