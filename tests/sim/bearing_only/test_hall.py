"""The hall against geometry, and the images of its camera: noise, repeats, corners that stay."""

from contextlib import AbstractContextManager, closing
from dataclasses import replace

import cv2
import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.bearing_only.hall import (
    CAMERA,
    CENTRE_PX,
    FOCAL_PX,
    HEIGHT_PX,
    TARGET,
    WIDTH_PX,
    HallCamera,
    HallConfig,
    hang_crates,
)
from sim.bearing_only.pictures import labels
from sim.geometry import R_BODY_CAMERA
from tracker.bearing_only.corners import CornerTracker
from tracker.bearing_only.measurements import PinholeCamera

PLAIN = HallConfig(wall_px_per_m=2.0, crate_count=1)


def made(config: HallConfig, seed: int) -> HallCamera:
    return HallCamera(config, np.random.default_rng(seed), np.random.default_rng(6))


def rotation(yaw: float, pitch: float = 0.0, roll: float = 0.0) -> np.ndarray:
    """Rz(yaw) Ry(pitch) Rx(roll)."""
    (cz, cy, cx), (sz, sy, sx) = np.cos([yaw, pitch, roll]), np.sin([yaw, pitch, roll])
    Rz = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    Ry = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    return Rz @ Ry @ np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])


def project(position_m, R, points_m) -> np.ndarray:
    """(n, 2) pixels of world points, from the image's edge: [Wu2022] Eqs. 24 to 26."""
    c = (np.asarray(points_m) - position_m) @ R @ R_BODY_CAMERA
    return CENTRE_PX + FOCAL_PX * c[..., :2] / c[..., 2:]


@pytest.fixture(scope="module")
def hall():
    """A hall with one crate."""
    with closing(made(PLAIN, 3)) as camera:
        yield camera


def mask_of(hall, name: str) -> np.ndarray:
    """(h, w) uint8 silhouette of a geom as the camera sees it."""
    kind, number = hall.renderer.segment(hall.model, hall.data, CAMERA)
    is_geom = kind == int(mujoco.mjtObj.mjOBJ_GEOM)
    return (is_geom & (number == hall.model.geom(name).id)).astype(np.uint8)


def centroid(mask: np.ndarray) -> np.ndarray:
    rows, columns = np.nonzero(mask)
    return np.array([columns.mean(), rows.mean()]) + 0.5


@pytest.mark.parametrize("yaw", [0.0, 2.0, -1.0])
@pytest.mark.parametrize("column", [-0.5, 0.0, 0.6])
@pytest.mark.parametrize("row", [-0.4, 0.3])
def test_the_target_is_where_it_is_projected(hall, yaw, column, row):
    """The silhouette of a ball is an ellipse, whose centre is a little off the ball's centre."""
    R, position = rotation(yaw, 0.1, 0.05), np.array([3.0, -2.0, 1.5])
    distance = 8.0
    c = distance * np.array([column, row, 1.0])
    target = position + R @ R_BODY_CAMERA @ c
    hall.show(position, R, target)
    sharpened = (c / (c[2] - PLAIN.target_radius_m**2 / c[2]))[:2]  # of the ellipse: c z / (z²-r²)
    expected = np.array(CENTRE_PX) + FOCAL_PX * sharpened
    assert np.abs(centroid(mask_of(hall, TARGET)) - expected).max() < 0.1
    assert np.abs(expected - project(position, R, target)).max() < 1.0


@pytest.mark.parametrize("off", [(0.2, 0.1, 0.0), (-0.3, -0.2, 0.1), (0.0, 0.25, -0.3)])
def test_a_crate_is_where_its_corners_are_projected(hall, off):
    x, y, z, half = hall.crates_m[0]
    signs = np.stack(np.meshgrid(*[[-1, 1]] * 3), axis=-1).reshape(-1, 3)
    corners = np.array([x, y, z]) + half * signs
    towards = np.array([x, y, z]) / np.linalg.norm([x, y, z])
    position = np.array([x, y, z]) - 6.0 * towards
    R = rotation(*np.add([np.arctan2(y, x), -np.arcsin(towards[2]), 0.0], off))
    hall.show(position, R, position - 5.0 * R[:, 0])
    hull = cv2.convexHull(np.float32(project(position, R, corners)))
    moments = cv2.moments(hull)
    expected = np.array([moments["m10"], moments["m01"]]) / moments["m00"]
    mask = mask_of(hall, "crates")
    assert np.abs(centroid(mask) - expected).max() < 0.15
    assert np.count_nonzero(mask) == pytest.approx(moments["m00"], rel=0.03)


def test_depth_of_the_walls(hall):
    hall.show(np.array([5.0, 0.0, 1.0]), rotation(np.pi), np.array([10.0, 0.0, 0.0]))
    _, depth_m = hall.renderer.render(hall.model, hall.data, CAMERA)
    assert depth_m[HEIGHT_PX // 2, WIDTH_PX // 2] == pytest.approx(30.0, abs=0.01)
    floor = FOCAL_PX * 11.0 / (HEIGHT_PX - 0.5 - CENTRE_PX[1])
    assert depth_m[-1, WIDTH_PX // 2] == pytest.approx(floor, abs=0.05)


@settings(max_examples=8)
@given(seed=st.integers(0, 10**6), half=st.floats(10.0, 20.0))
def test_no_crate_is_in_the_clear_part_nor_in_a_wall(seed, half):
    config = replace(PLAIN, crate_count=30, clear_m=(half, half, 0.25 * half), wall_px_per_m=0.5)
    crates = hang_crates(config, np.random.default_rng(seed))
    assert crates.shape == (30, 4)
    assert (np.abs(crates[:, :3]) + crates[:, 3:] <= config.hall_m).all()
    off = np.abs(crates[:, :3] - [0.0, 0.0, config.clear_height_m]) - crates[:, 3:]
    assert (off > config.clear_m).any(axis=1).all()


def test_the_same_stream_makes_the_same_hall():
    halls = [made(PLAIN, seed) for seed in (1, 1, 2)]
    first, again, other = (hall.model for hall in halls)
    assert np.array_equal(first.tex_data, again.tex_data)
    assert np.array_equal(first.mesh_vert, again.mesh_vert)
    assert not np.array_equal(first.tex_data, other.tex_data)
    for hall in halls:
        hall.close()


def test_nothing_but_the_target_has_its_colour():
    with closing(made(HallConfig(), 0)) as hall:
        texels = hall.model.tex_data.reshape(-1, 1, 3)
    saturation = cv2.cvtColor(texels, cv2.COLOR_RGB2HSV)[..., 1]
    target = np.uint8([[np.multiply(255, HallConfig().target_rgb)]])
    assert np.quantile(saturation, 0.999) < 0.8 * cv2.cvtColor(target, cv2.COLOR_RGB2HSV)[0, 0, 1]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"hall_m": (0.0, 1.0, 1.0)}, "hall_m"),
        ({"clear_m": (20.0, np.nan, 5.0)}, "clear_m"),
        ({"target_radius_m": -1.0}, "target_radius_m.*-1.0"),
        ({"crate_m": (2.0, 1.0)}, "crate_m"),
        ({"crate_count": -1}, "crate_count"),
        ({"clear_m": (25.0, 25.0, 9.0)}, "no room"),
    ],
)
def test_an_impossible_hall_is_refused(change, message):
    with pytest.raises(ValueError, match=message):
        HallConfig(**change)


def test_labels_fill_a_square():
    assert labels(16, 9, np.random.default_rng(0)).shape == (48, 48, 3)
    with pytest.raises(ValueError, match="square number"):
        labels(16, 8, np.random.default_rng(0))


SMALL = HallConfig(wall_px_per_m=12.0, crate_count=20)
POSITION, BALL = np.array([10.0, 15.0, 1.0]), np.array([0.0, 15.0, 1.0])


def facing(yaw: float) -> np.ndarray:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def camera(noise_std: float = 2.0) -> AbstractContextManager[HallCamera]:
    return closing(made(replace(SMALL, noise_std=noise_std), 5))


def test_the_estimators_camera_is_the_one_that_renders():
    ours = PinholeCamera()
    assert (ours.s_u_px, ours.s_v_px) == (FOCAL_PX, FOCAL_PX)
    assert (ours.u0_px, ours.v0_px) == CENTRE_PX
    assert (ours.width_px, ours.height_px) == (WIDTH_PX, HEIGHT_PX)


def test_noise_is_as_large_as_said_and_new_in_each_image():
    with camera() as noisy, camera(0.0) as clean:
        still = clean.photograph(POSITION, facing(np.pi), BALL).astype(float)
        first, second = (noisy.photograph(POSITION, facing(np.pi), BALL) for _ in range(2))
    assert np.std(first - still) == pytest.approx(2.0, rel=0.05)
    assert np.corrcoef((first - still).ravel(), (second - still).ravel())[0, 1] < 0.02


def test_the_same_streams_take_the_same_images():
    with camera() as one, camera() as two:
        a, b = (c.photograph(POSITION, facing(3.0), BALL) for c in (one, two))
    assert np.array_equal(a, b)


def test_the_reference_photograph_is_full_of_the_target():
    with camera() as taking:
        hsv = cv2.cvtColor(np.ascontiguousarray(taking.reference_photograph()), cv2.COLOR_RGB2HSV)
    assert np.ptp(hsv[..., 0].astype(int)) <= 8
    assert hsv[..., 1].min() > 180


def test_a_corner_stays_on_the_same_point_of_the_hall():
    """Points of the first image, taken into the hall by their depth, reappear where followed."""
    corners = CornerTracker()
    with camera() as taking:
        image = taking.photograph(POSITION, facing(np.pi), BALL)
        _, depth_m = taking.renderer.render(taking.model, taking.data, CAMERA)
        first = corners.update(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY))
        column, row = first.pixels.astype(int).T
        z = depth_m[row, column, None]
        c = np.column_stack([(first.pixels - CENTRE_PX) / FOCAL_PX * z, z])
        world = POSITION + c @ (facing(np.pi) @ R_BODY_CAMERA).T
        for step in range(1, 11):
            position = POSITION + 0.12 * step * np.array([-0.3, 1.0, 0.4])
            R = facing(np.pi - 0.01 * step)
            image = taking.photograph(position, R, BALL)
            seen = corners.update(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY))
    c = (world - position) @ R @ R_BODY_CAMERA
    expected = np.array(CENTRE_PX) + FOCAL_PX * c[:, :2] / c[:, 2:]
    kept = np.isin(seen.ids, first.ids)
    errors = np.linalg.norm(seen.pixels[kept] - expected[seen.ids[kept]], axis=1)
    assert kept.sum() > 20
    assert np.median(errors) < 0.3
    assert np.median(np.linalg.norm(seen.pixels[kept] - first.pixels[seen.ids[kept]], axis=1)) > 5


@pytest.mark.parametrize("noise", [-1.0, float("nan")])
def test_an_impossible_noise_is_refused(noise):
    with pytest.raises(ValueError, match="noise_std"):
        HallConfig(noise_std=noise)
