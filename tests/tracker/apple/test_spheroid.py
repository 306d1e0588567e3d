import math

import fruits
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker.apple.attitude import unit
from tracker.apple.next_view import looking_at
from tracker.apple.spheroid import (
    Spheroid,
    cone_of_ellipse,
    ellipse_of_cone,
    principal_cone,
)
from tracker.apple.view import CameraPose
from tracker.geometry import project, rays_of


@st.composite
def scenes(draw):
    """A fruit and a camera that has it in view, not in the middle."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    aspect = draw(st.sampled_from([0.7, 0.85, 0.95, 1.0, 1.2]))
    fruit = fruits.apple(unit(rng.standard_normal(3)), aspect)
    place = fruit.centre_m + rng.uniform(0.15, 0.8) * unit(rng.standard_normal(3))
    pose = looking_at(fruit.centre_m + rng.uniform(-0.02, 0.02, 3), place)
    roll = fruits.rotation([0.0, 0.0, rng.uniform(-math.pi, math.pi)])
    return fruit, CameraPose(pose.rotation @ roll, place)


def touching(fruit, pose, pixels):
    """Discriminant of each ray with the surface, by its equation: 0 where it touches."""
    d = rays_of(pixels, fruits.K) @ pose.rotation.T
    B = np.eye(3) + (fruit.aspect**-2 - 1.0) * np.outer(fruit.axis, fruit.axis)
    away = pose.position_m - fruit.centre_m
    a, b = np.einsum("ni,ij,nj->n", d, B, d), d @ B @ away
    return (b**2 - a * (away @ B @ away - fruit.radius_m**2)) / b**2


@given(scenes())
def test_rays_of_the_outline_touch_the_surface(scene):
    fruit, pose = scene
    outline = fruit.outline_px(fruits.K, pose, 40)
    np.testing.assert_allclose(touching(fruit, pose, outline), 0.0, atol=1e-9)


@given(scenes())
def test_an_ellipse_and_its_cone_are_the_same(scene):
    fruit, pose = scene
    C = fruit.cone(pose)
    again = cone_of_ellipse(*ellipse_of_cone(C, fruits.K), fruits.K)
    np.testing.assert_allclose(again / np.linalg.norm(again), C / np.linalg.norm(C), atol=1e-9)


@given(scenes())
def test_the_outline_lies_on_the_ellipse(scene):
    fruit, pose = scene
    centre, semi_axes, angle = ellipse_of_cone(fruit.cone(pose), fruits.K)
    c, s = math.cos(angle), math.sin(angle)
    local = (fruit.outline_px(fruits.K, pose, 30) - centre) @ np.array([[c, s], [-s, c]]).T
    np.testing.assert_allclose(((local / semi_axes) ** 2).sum(axis=1), 1.0, atol=1e-7)
    assert semi_axes[0] >= semi_axes[1]


@given(scenes())
def test_the_cone_is_symmetric_about_the_plane_of_camera_and_axis(scene):
    """One principal direction is perpendicular to that plane: what method 1 rests upon."""
    fruit, pose = scene
    if fruit.aspect == 1.0:
        return
    across = np.cross(fruit.centre_m - pose.position_m, fruit.axis)
    if np.linalg.norm(across) < 0.05 * np.linalg.norm(fruit.centre_m - pose.position_m):
        return
    directions, _ = principal_cone(fruit.cone(pose))
    wide = 0 if fruit.aspect < 1.0 else 1
    alike = abs(float((pose.rotation @ directions[wide]) @ unit(across)))
    assert alike == pytest.approx(1.0, abs=1e-9)


def test_a_ball_on_the_optical_axis():
    """Radius 0.3 at distance 0.5: the rays touch at a slope of 3 / 4."""
    ball = Spheroid(np.array([0.0, 0.0, 0.5]), np.array([0.0, 0.0, 1.0]), 0.3, 1.0)
    pose = CameraPose(np.eye(3), np.zeros(3))
    centre, semi_axes, _ = ellipse_of_cone(ball.cone(pose), fruits.K)
    np.testing.assert_allclose(centre, fruits.K[:2, 2])
    np.testing.assert_allclose(semi_axes, 0.75 * fruits.K[0, 0])
    _, half_angles = principal_cone(ball.cone(pose))
    np.testing.assert_allclose(half_angles, math.atan(0.75))


def test_the_calyx_is_at_the_pole_that_the_axis_points_away_from():
    fruit = fruits.apple((1.0, 0.0, 0.0), aspect=0.8)
    np.testing.assert_allclose(fruit.calyx_m, fruits.CENTRE_M - [0.032, 0.0, 0.0])
    front = looking_at(fruits.CENTRE_M, fruits.CENTRE_M - [0.4, 0.0, 0.0])
    back = looking_at(fruits.CENTRE_M, fruits.CENTRE_M + np.array([0.4, 0.0, 0.0]))
    assert fruit.calyx_facing(front) == pytest.approx(1.0)
    assert fruit.calyx_facing(back) == pytest.approx(-1.0)
    np.testing.assert_allclose(fruit.calyx_px(fruits.K, front), fruits.K[:2, 2], atol=1e-9)


@given(scenes())
def test_a_calyx_that_faces_the_camera_is_not_behind_the_fruit(scene):
    fruit, pose = scene
    to_calyx = fruit.calyx_m - pose.position_m
    B = np.eye(3) + (fruit.aspect**-2 - 1.0) * np.outer(fruit.axis, fruit.axis)
    near = pose.position_m + 0.999 * to_calyx - fruit.centre_m
    is_outside = near @ B @ near > fruit.radius_m**2
    if abs(fruit.calyx_facing(pose)) > 0.02:
        assert is_outside == (fruit.calyx_facing(pose) > 0.0)


def test_rays_and_pixels_are_inverse():
    pixels = np.random.default_rng(0).uniform(0.0, 600.0, (20, 2))
    np.testing.assert_allclose(project(3.0 * rays_of(pixels, fruits.K), fruits.K), pixels)


def test_what_cannot_be_is_refused():
    with pytest.raises(ValueError, match="unit vector"):
        Spheroid(np.zeros(3), np.array([0.0, 0.0, 2.0]), 0.04, 0.9)
    with pytest.raises(ValueError, match="radius_m must be a positive number, got -1"):
        Spheroid(np.zeros(3), np.array([0.0, 0.0, 1.0]), -1.0, 0.9)
    with pytest.raises(ValueError, match="inside the fruit"):
        fruits.apple().cone(CameraPose(np.eye(3), fruits.CENTRE_M))
    with pytest.raises(ValueError, match="not that of an elliptic cone"):
        principal_cone(np.eye(3))
