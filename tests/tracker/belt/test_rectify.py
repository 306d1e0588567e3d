import math

import numpy as np
import pytest
from scenes import far_side_camera, pixel_of_world

from tracker.belt.image import ArrayImage
from tracker.belt.rectify import OverheadView


def test_pixel_and_world_round_trip(view):
    pixel = np.random.default_rng(0).uniform(0, 140, (20, 2))
    np.testing.assert_allclose(pixel_of_world(view, view.world_of_pixel(pixel)), pixel, atol=1e-9)


def test_homography_equals_projection_of_world_points(view):
    pixel = np.random.default_rng(1).uniform(0, 140, (20, 2))
    world = view.world_of_pixel(pixel)
    T = np.linalg.inv(view.T_world_camera)
    q = (world @ T[:3, :3].T + T[:3, 3]) @ view.K.T
    np.testing.assert_allclose(view.camera_of_pixel(pixel), q[:, :2] / q[:, 2:], atol=1e-9)


def test_overhead_view_is_not_mirrored(view):
    """Columns follow +y and rows +x, so that column x row points down: the view from above."""
    origin, right, down = view.world_of_pixel(np.array([[0, 0], [1, 0], [0, 1]]))
    assert np.cross(right - origin, down - origin)[2] < 0


def test_box_lands_where_it_stands_with_its_known_size(view, scene, template, true_warp):
    from tracker.affine.likelihood import LikelihoodConfig, TemplateObservation
    from tracker.affine.patches import Layers, PatchMatcher

    rgb, depth = scene.render(0.53, 0.1, 0.7)
    image = view.rectify(ArrayImage(rgb, depth))
    layers = Layers.of(image.grey, image.visibility)
    observation = TemplateObservation(PatchMatcher(template), layers, LikelihoodConfig(), 0.3)
    warps = np.stack([true_warp(0.53, 0.1, 0.7), true_warp(0.53, 0.104, 0.7)])
    ncc = observation.fit(warps).ncc
    assert ncc[0] > 0.95
    assert ncc[0] > ncc[1] + 0.02


def test_heights_and_visibility_come_from_depth(view, scene):
    rgb, depth = scene.render(0.5, 0.0, 0.0, occluder=(0.45, 0.55, 0.05, 0.1, 0.2))
    image = view.rectify(ArrayImage(rgb, depth))
    column, row = np.rint(pixel_of_world(view, np.array([0.5, 0.0]))).astype(int)
    assert abs(image.height_m[row, column]) < 0.01
    assert image.visibility[row, column] == 1
    q = scene.K @ np.linalg.inv(scene.T_world_camera)[:3] @ [0.5, 0.075, 0.2, 1.0]
    distance = np.linalg.norm(
        view._camera_coordinates - (q[:2] / q[2]), axis=-1
    )  # overhead pixel whose ray meets the middle of the occluder
    row, column = np.unravel_index(np.argmin(distance), distance.shape)
    assert image.visibility[row, column] == 0


def test_missing_depth_hides_nothing(view, scene):
    rgb, depth = scene.render(0.5, 0.0, 0.0)
    inside = view.rectify(ArrayImage(rgb, None)).visibility
    for nothing in (np.zeros_like(depth), np.full_like(depth, np.nan)):
        image = view.rectify(ArrayImage(rgb, nothing))
        np.testing.assert_array_equal(image.visibility, inside)
        assert np.isnan(image.height_m).all()


def test_outside_the_camera_image_nothing_is_visible(camera):
    view = OverheadView(*camera, (480, 640), y_range_m=(-2.0, 2.0))
    visibility = view.rectify(ArrayImage(np.full((480, 640, 3), 90, np.uint8), None)).visibility
    assert visibility[:, 0].max() == 0
    assert visibility[:, visibility.shape[1] // 2].max() == 1


def test_noisy_depth_hides_what_stands_high_but_not_the_plane(camera, scene):
    views = [OverheadView(*camera, (480, 640), depth_noise_m=m) for m in (0.002, 0.016)]
    rgb, depth = scene.render(0.53, 0.1, 0.7, occluder=(0.3, 0.7, -0.2, -0.05, 0.2))
    noise = np.random.default_rng(3).normal(0.0, 0.016, depth.shape).astype(np.float32)
    seen = views[0].rectify(ArrayImage(rgb, depth)).visibility > 0
    noisy = views[1].rectify(ArrayImage(rgb, depth + noise)).visibility > 0
    assert (~seen).sum() > 1000
    assert noisy[seen].mean() > 0.97
    assert noisy[~seen].mean() < 0.05


class Watched(ArrayImage):
    """Remembers which pixels it was asked for."""

    def crop(self, window):
        object.__setattr__(self, "asked", window)
        return super().crop(window)


@pytest.mark.parametrize("region", [(40, 100, 60, 200), (0, 148, 0, 40), (70, 71, 300, 301)])
def test_region_is_the_part_of_the_whole_and_needs_few_pixels(view, scene, region):
    top, bottom, left, right = region
    region = slice(top, bottom), slice(left, right)
    rgb, depth = scene.render(0.53, -0.4, 0.7, occluder=(0.45, 0.55, -0.5, -0.4, 0.2))
    image = Watched(rgb, depth)
    part, whole = view.rectify(image, region), view.rectify(ArrayImage(rgb, depth))
    np.testing.assert_array_equal(part.grey[region], whole.grey[region])
    np.testing.assert_array_equal(part.height_m[region], whole.height_m[region])
    inner = slice(top + 1, bottom - 1), slice(left + 1, right - 1)  # a hidden pixel hides others
    np.testing.assert_array_equal(part.visibility[inner], whole.visibility[inner])
    rest = np.ones(view.shape_px, bool)
    rest[region] = False
    assert not part.grey[rest].any() and not part.visibility[rest].any()
    assert np.isnan(part.height_m[rest]).all()
    rows, columns = image.asked
    share = (bottom - top) * (right - left) / part.grey.size
    assert (rows.stop - rows.start) * (columns.stop - columns.start) < 640 * 480 * share + 500


def test_region_beyond_the_camera_image_is_hidden(view):
    image = Watched(np.full((480, 640, 3), 90, np.uint8), None)
    narrow = OverheadView(view.K, view.T_world_camera, (480, 640), y_range_m=(-4.0, 4.0))
    overhead = narrow.rectify(image, (slice(0, 148), slice(0, 10)))
    assert not overhead.visibility.any() and not hasattr(image, "asked")


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("K", np.eye(4)),
        ("T_world_camera", np.eye(3)),
        ("image_shape_px", (480,)),
        ("m_per_px", 0.0),
        ("m_per_px", math.nan),
        ("x_range_m", (0.7, 0.3)),
        ("plane_z_m", 5.0),
        ("depth_noise_m", 0.0),
    ],
)
def test_impossible_geometry_is_refused(field, value):
    K, T = far_side_camera()
    settings = {"K": K, "T_world_camera": T, "image_shape_px": (480, 640)} | {field: value}
    with pytest.raises(ValueError, match=field):
        OverheadView(**settings)
