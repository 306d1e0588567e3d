"""The hall against geometry: intrinsics, poses and silhouettes; where crates may be."""

from dataclasses import replace

import cv2
import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.bearing_only.pictures import labels
from sim.bearing_only.scene import (
    CAMERA,
    CENTRE_PX,
    FOCAL_PX,
    HEIGHT_PX,
    TARGET,
    WIDTH_PX,
    FlightScene,
    FlightSceneConfig,
)
from sim.geometry import R_BODY_CAMERA
from sim.imaging.camera import OffscreenRenderer

PLAIN = FlightSceneConfig(wall_px_per_m=2.0, crate_count=1)


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
def stage():
    """A hall with one crate, and what renders it."""
    scene = FlightScene(PLAIN, np.random.default_rng(3))
    with OffscreenRenderer(scene.model, WIDTH_PX, HEIGHT_PX) as renderer:
        yield scene, renderer


def mask_of(stage, name: str) -> np.ndarray:
    """(h, w) uint8 silhouette of a geom as the camera sees it."""
    scene, renderer = stage
    kind, number = renderer.segment(scene.model, scene.data, CAMERA)
    is_geom = kind == int(mujoco.mjtObj.mjOBJ_GEOM)
    return (is_geom & (number == scene.model.geom(name).id)).astype(np.uint8)


def centroid(mask: np.ndarray) -> np.ndarray:
    rows, columns = np.nonzero(mask)
    return np.array([columns.mean(), rows.mean()]) + 0.5


@pytest.mark.parametrize("yaw", [0.0, 2.0, -1.0])
@pytest.mark.parametrize("column", [-0.5, 0.0, 0.6])
@pytest.mark.parametrize("row", [-0.4, 0.3])
def test_the_target_is_where_it_is_projected(stage, yaw, column, row):
    """The silhouette of a ball is an ellipse, whose centre is a little off the ball's centre."""
    scene, _ = stage
    R, position = rotation(yaw, 0.1, 0.05), np.array([3.0, -2.0, 1.5])
    distance = 8.0
    c = distance * np.array([column, row, 1.0])
    target = position + R @ R_BODY_CAMERA @ c
    scene.show(position, R, target)
    sharpened = (c / (c[2] - PLAIN.target_radius_m**2 / c[2]))[:2]  # of the ellipse: c z / (z²-r²)
    expected = np.array(CENTRE_PX) + FOCAL_PX * sharpened
    assert np.abs(centroid(mask_of(stage, TARGET)) - expected).max() < 0.1
    assert np.abs(expected - project(position, R, target)).max() < 1.0


@pytest.mark.parametrize("off", [(0.2, 0.1, 0.0), (-0.3, -0.2, 0.1), (0.0, 0.25, -0.3)])
def test_a_crate_is_where_its_corners_are_projected(stage, off):
    scene, _ = stage
    x, y, z, half = scene.crates_m[0]
    signs = np.stack(np.meshgrid(*[[-1, 1]] * 3), axis=-1).reshape(-1, 3)
    corners = np.array([x, y, z]) + half * signs
    towards = np.array([x, y, z]) / np.linalg.norm([x, y, z])
    position = np.array([x, y, z]) - 6.0 * towards
    R = rotation(*np.add([np.arctan2(y, x), -np.arcsin(towards[2]), 0.0], off))
    scene.show(position, R, position - 5.0 * R[:, 0])
    hull = cv2.convexHull(np.float32(project(position, R, corners)))
    moments = cv2.moments(hull)
    expected = np.array([moments["m10"], moments["m01"]]) / moments["m00"]
    mask = mask_of(stage, "crates")
    assert np.abs(centroid(mask) - expected).max() < 0.15
    assert np.count_nonzero(mask) == pytest.approx(moments["m00"], rel=0.03)


def test_depth_of_the_walls(stage):
    scene, renderer = stage
    scene.show(np.array([5.0, 0.0, 1.0]), rotation(np.pi), np.array([10.0, 0.0, 0.0]))
    _, depth_m = renderer.render(scene.model, scene.data, CAMERA)
    assert depth_m[HEIGHT_PX // 2, WIDTH_PX // 2] == pytest.approx(30.0, abs=0.01)
    floor = FOCAL_PX * 11.0 / (HEIGHT_PX - 0.5 - CENTRE_PX[1])
    assert depth_m[-1, WIDTH_PX // 2] == pytest.approx(floor, abs=0.05)


@settings(max_examples=8)
@given(seed=st.integers(0, 10**6), half=st.floats(10.0, 20.0))
def test_no_crate_is_in_the_clear_part_nor_in_a_wall(seed, half):
    config = replace(PLAIN, crate_count=30, clear_m=(half, half, 0.25 * half), wall_px_per_m=0.5)
    crates = FlightScene(config, np.random.default_rng(seed)).crates_m
    assert crates.shape == (30, 4)
    assert (np.abs(crates[:, :3]) + crates[:, 3:] <= config.hall_m).all()
    off = np.abs(crates[:, :3] - [0.0, 0.0, config.clear_height_m]) - crates[:, 3:]
    assert (off > config.clear_m).any(axis=1).all()


def test_the_same_stream_makes_the_same_hall():
    first, again, other = (
        FlightScene(PLAIN, np.random.default_rng(seed)).model for seed in (1, 1, 2)
    )
    assert np.array_equal(first.tex_data, again.tex_data)
    assert np.array_equal(first.mesh_vert, again.mesh_vert)
    assert not np.array_equal(first.tex_data, other.tex_data)


def test_nothing_but_the_target_has_its_colour():
    scene = FlightScene(FlightSceneConfig(), np.random.default_rng(0))
    texels = scene.model.tex_data.reshape(-1, 1, 3)
    saturation = cv2.cvtColor(texels, cv2.COLOR_RGB2HSV)[..., 1]
    target = np.uint8([[np.multiply(255, FlightSceneConfig().target_rgb)]])
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
        FlightSceneConfig(**change)


def test_labels_fill_a_square():
    assert labels(16, 9, np.random.default_rng(0)).shape == (48, 48, 3)
    with pytest.raises(ValueError, match="square number"):
        labels(16, 8, np.random.default_rng(0))
