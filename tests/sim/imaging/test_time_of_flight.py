"""Time-of-flight depth against planes whose angle is known, and against the published noise."""

import math

import numpy as np
import pytest

from sim.imaging.camera import CAMERAS
from sim.imaging.degradations import get_condition
from sim.imaging.sensor import SensorNoise
from sim.imaging.time_of_flight import TimeOfFlight, incidence_angle_rad, noise_std_m

WIDTH, HEIGHT = 512, 424
K = CAMERAS["kinect"].intrinsics(WIDTH, HEIGHT)


def plane(tilt_rad: float, distance_m: float) -> np.ndarray:
    """Depth of a plane through the point `distance_m` ahead, its normal turned by `tilt_rad`."""
    u, v = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    x, y = (u - K[0, 2]) / K[0, 0], (v - K[1, 2]) / K[1, 1]
    n = np.array([0.0, math.sin(tilt_rad), math.cos(tilt_rad)])
    inverse = (n[0] * x + n[1] * y + n[2]) / (distance_m * n[2])
    return (1.0 / np.maximum(inverse, 1.0 / 20.0)).astype(np.float32)


def draws(seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    shape = HEIGHT, WIDTH
    return rng.standard_normal(shape, np.float32), rng.random(shape, np.float32)


def test_view_is_that_of_the_depth_camera():
    """70.6 by 60 degrees, and calibrated units have focal lengths near 365 px."""
    across = 2.0 * math.degrees(math.atan(0.5 * WIDTH / K[0, 0]))
    assert across == pytest.approx(70.6, abs=1.0)
    assert K[0, 0] == pytest.approx(365.5, rel=0.01)


@pytest.mark.parametrize("tilt_rad", [0.0, 0.4, 0.9])
def test_incidence_angle_of_a_plane_is_exact(tilt_rad):
    angle = incidence_angle_rad(plane(tilt_rad, 1.5), K)
    row, column = HEIGHT // 2, WIDTH // 2
    assert angle[row, column] == pytest.approx(tilt_rad, abs=3e-3)
    x, y = (400 - K[0, 2]) / K[0, 0], (100 - K[1, 2]) / K[1, 1]
    ray = np.array([x, y, 1.0]) / math.sqrt(x * x + y * y + 1.0)
    normal = [0.0, math.sin(tilt_rad), math.cos(tilt_rad)]
    assert angle[100, 400] == pytest.approx(math.acos(ray @ normal), abs=3e-3)


@pytest.mark.parametrize(
    ("depth_m", "angle_rad", "std_mm"),
    [(1.0, 0.0, 1.3), (2.0, 0.0, 1.7), (4.0, 0.0, 4.3), (1.0, math.pi / 4, 1.4)],
)
def test_noise_is_the_published_one(depth_m, angle_rad, std_mm):
    assert noise_std_m(np.array(depth_m), np.array(angle_rad)) == pytest.approx(1e-3 * std_mm)


@pytest.mark.parametrize(("tilt_rad", "distance_m"), [(0.0, 1.0), (0.9, 1.5), (0.0, 3.0)])
def test_measured_plane_is_unbiased_with_that_noise(tilt_rad, distance_m):
    truth = plane(tilt_rad, distance_m)
    error = TimeOfFlight().measure(truth, K, *draws(0)) - truth
    middle = np.s_[HEIGHT // 2 - 20 : HEIGHT // 2 + 20, WIDTH // 2 - 20 : WIDTH // 2 + 20]
    expected = float(noise_std_m(np.array(distance_m), np.array(tilt_rad)))
    assert error[middle].std() == pytest.approx(expected, rel=0.1)
    assert abs(error[middle].mean()) < 4.0 * expected / 40.0


def test_edges_lose_half_their_pixels_and_the_rest_fly_between():
    truth = np.full((HEIGHT, WIDTH), 1.5, np.float32)
    truth[:, 200:] = 1.2
    measured = TimeOfFlight().measure(truth, K, *draws(1))
    band = measured[:, 199:201]
    flying = band[band > 0.0]
    assert np.mean(band == 0.0) == pytest.approx(0.5, abs=0.06)
    assert flying.min() >= 1.2 - 1e-6 and flying.max() <= 1.5 + 1e-6
    assert flying.std() == pytest.approx(0.3 / math.sqrt(12.0), rel=0.1)
    assert (np.abs(measured[:, 202:] - 1.2) < 0.02).all()
    assert (np.abs(measured[:, :198] - 1.5) < 0.02).all()


def test_grazing_surfaces_return_nothing():
    measured = TimeOfFlight().measure(plane(math.radians(84.0), 2.0), K, *draws(2))
    assert measured[HEIGHT // 2, WIDTH // 2] == 0.0


def test_the_condition_measures_depth_this_way():
    condition = get_condition("kinect-1")
    truth = plane(0.0, 2.0)
    rgb = np.full((HEIGHT, WIDTH, 3), 100, np.uint8)
    noise = SensorNoise(condition, np.random.default_rng(0), K)
    whole = slice(0, HEIGHT), slice(0, WIDTH)
    frames = [noise.draw()(lambda part: (rgb[part], truth[part]), whole)[1] for _ in range(2)]
    assert (condition.width_px, condition.height_px) == (WIDTH, HEIGHT)
    assert not np.array_equal(frames[0], frames[1])
    middle = (frames[0] - truth)[180:240, 220:280]
    assert middle.std() == pytest.approx(0.0017, rel=0.1)
    with pytest.raises(ValueError, match="K must be given"):
        SensorNoise(condition, np.random.default_rng(0))


@pytest.mark.parametrize(
    ("field", "value"), [("edge_step_m", 0.0), ("edge_hole_share", 1.5), ("grazing_rad", 2.0)]
)
def test_bad_models_are_refused(field, value):
    with pytest.raises(ValueError, match=f"{field} must be .* got"):
        TimeOfFlight(**{field: value})
