"""The rendered fruit against its geometry, and the geometry against its definition."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.apple.fruit import Fruit, PlacedFruit
from sim.apple.world import FREE_CAMERA, intrinsics
from sim.geometry import look_at


def area_of(polygon):
    x, y = polygon.T
    return 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


@pytest.mark.parametrize("axis", [(0.3, 0.1, 1.0), (1.0, 0.3, 0.2), (0.0, 1.0, 0.1)])
@pytest.mark.parametrize("range_m", [0.22, 0.6])
def test_the_rendered_silhouette_is_the_analytic_outline_within_a_pixel(make, axis, range_m):
    fruit = make["placed"](axis)
    T = make["view"](range_m, turn_rad=0.3, at=fruit.centre_m + np.array([0.0, 0.03, 0.02]))
    with make["orchard"](fruit) as orchard:
        orchard.set_free_camera(T)
        masks = orchard.masks(FREE_CAMERA)
    mask = (masks.fruit & ~masks.calyx) | _inside(masks.calyx, fruit, T)
    outline = fruit.outline_px(intrinsics(), T, 2000)
    contours, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    edge = max(contours, key=len)[:, 0].astype(float)
    p = np.linalg.inv(T) @ [*(2.0 * fruit.centre_m - fruit.calyx_m), 1.0]
    u, v, w = intrinsics() @ p[:3]
    stem_px = 2.0 * fruit.fruit.stem_radius_m * intrinsics()[0, 0] / w
    edge = edge[np.hypot(edge[:, 0] - u / w, edge[:, 1] - v / w) > stem_px + 2.0]
    distance = np.linalg.norm(edge[:, None] - outline[None], axis=2).min(axis=1)
    assert distance.max() < 1.3  # a pixel's centre lies up to a pixel inside; 0.3 for the facets
    assert mask.sum() == pytest.approx(area_of(outline), rel=0.01)


def _inside(calyx, fruit, T):
    """The part of the calyx that is not beyond the spheroid's outline: it stands out a little."""
    filled = np.zeros(calyx.shape, np.uint8)
    outline = np.rint(fruit.outline_px(intrinsics(), T, 400)).astype(np.int32)
    cv2.fillPoly(filled, [outline], 1)
    return calyx & (filled > 0)


def test_the_rendered_calyx_is_where_the_pole_projects(make):
    fruit = make["placed"]((1.0, 0.3, 0.2))
    T = make["view"](0.3)
    with make["orchard"](fruit) as orchard:
        orchard.set_free_camera(T)
        rows, columns = np.nonzero(orchard.masks(FREE_CAMERA).calyx)
    p = np.linalg.inv(T) @ [*fruit.calyx_m, 1.0]
    u, v, w = intrinsics() @ p[:3]
    assert (T[:3, 3] - fruit.calyx_m) @ fruit.axis < 0.0
    assert (columns.mean(), rows.mean()) == pytest.approx((u / w, v / w), abs=1.0)


def test_a_calyx_on_the_far_side_is_not_seen(make):
    fruit = make["placed"]((-1.0, 0.0, 0.3))
    with make["orchard"](fruit) as orchard:
        orchard.set_free_camera(make["view"](0.3))
        assert not orchard.masks(FREE_CAMERA).calyx.any()
    assert (make["view"](0.3)[:3, 3] - fruit.calyx_m) @ fruit.axis > 0.0


@given(st.floats(0.7, 1.2), st.floats(-1.2, 1.2), st.floats(0.1, np.pi - 0.1), st.floats(0.2, 1.0))
def test_rays_through_the_outline_touch_the_spheroid(aspect, azimuth, polar, range_m):
    axis = np.array(
        [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)]
    )
    fruit = PlacedFruit(Fruit(aspect=aspect), np.array([1.0, 0.1, 0.2]), axis)
    eye = fruit.centre_m - range_m * np.array([0.9, 0.3, -0.2]) / np.linalg.norm([0.9, 0.3, 0.2])
    T = look_at(eye, fruit.centre_m + np.array([0.0, 0.01, 0.0]))
    pixels = fruit.outline_px(intrinsics(), T, 24)
    rays = np.column_stack([pixels, np.ones(24)]) @ np.linalg.inv(intrinsics()).T @ T[:3, :3].T
    # In coordinates in which the fruit is the unit sphere, a tangent passes it at distance 1.
    along = np.outer(axis, axis)
    to_sphere = (np.eye(3) - along + along / aspect) / fruit.fruit.radius_m
    start, direction = to_sphere @ (eye - fruit.centre_m), rays @ to_sphere.T
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    assert np.linalg.norm(np.cross(start, direction), axis=1) == pytest.approx(1.0, abs=1e-6)


def test_a_sphere_on_the_optical_axis_has_a_circle_of_known_radius():
    fruit = PlacedFruit(Fruit(radius_m=0.04, aspect=1.0), np.array([0.5, 0, 0]), np.eye(3)[2])
    outline = fruit.outline_px(intrinsics(), look_at(np.zeros(3), fruit.centre_m), 16)
    radius_px = intrinsics()[0, 0] * 0.04 / np.sqrt(0.5**2 - 0.04**2)  # f tan(asin(r / d))
    assert np.linalg.norm(outline - [319.5, 239.5], axis=1) == pytest.approx(radius_px)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"radius_m": 0.0}, "radius_m must be a positive number, got 0.0"),
        ({"aspect": 0.2}, "aspect must be a number from 0.5 to 1.5, got 0.2"),
        ({"stem_length_m": float("nan")}, "stem_length_m must be a positive number, got nan"),
    ],
)
def test_a_fruit_that_cannot_be_is_refused(values, message):
    with pytest.raises(ValueError, match=message):
        Fruit(**values)


def test_an_axis_that_is_no_direction_is_refused():
    with pytest.raises(ValueError, match="axis must be a unit vector"):
        PlacedFruit(Fruit(), np.zeros(3), np.array([0.0, 0.0, 2.0]))
    with pytest.raises(ValueError, match="centre_m must be 3 finite numbers"):
        PlacedFruit(Fruit(), np.array([0.0, np.inf, 0.0]), np.eye(3)[2])
