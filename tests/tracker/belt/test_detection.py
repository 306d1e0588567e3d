import math

import numpy as np
import pytest
from scenes import angle_error, belt_sheet

from tracker.affine import aff2
from tracker.belt.detection import DetectionConfig, TemplateDetector
from tracker.belt.image import ArrayImage


@pytest.fixture(scope="module")
def detector(template, view, unit_px):
    return TemplateDetector(template, unit_px, view.shape_px, DetectionConfig())


def find(detector, view, scene, *place, **options):
    image = view.rectify(ArrayImage(*scene.render(*place, **options)))
    return detector.detect(image.grey, image.visibility)


@pytest.mark.parametrize("yaw", np.linspace(-3.1, 2.9, 9))
@pytest.mark.parametrize("light", [1.0, 0.3])
def test_finds_the_box_at_any_yaw_and_in_dim_light(detector, view, scene, yaw, light):
    scene.light = light
    x, y = 0.5 + 0.06 * math.sin(5 * yaw), 0.3 * math.cos(3 * yaw)
    found = find(detector, view, scene, x, y, yaw)
    assert found is not None
    p = aff2.polar(found.warp)
    np.testing.assert_allclose(view.world_of_pixel(p[4:])[:2], [x, y], atol=1.5e-3)
    assert abs(angle_error(math.pi / 2 - p[2], yaw)) < math.radians(1.0)


def test_an_empty_belt_gives_nothing(detector, view, scene):
    for _ in range(3):
        assert find(detector, view, scene, 0.5, 0.0, 0.0, with_box=False) is None


def test_another_carton_gives_nothing(detector, view, camera):
    from scenes import Scene

    other = Scene(*camera)
    other.picture = np.ascontiguousarray(belt_sheet(9)[:160, :400] // 2 + 90)
    for yaw in (0.0, 1.0):
        assert find(detector, view, other, 0.5, 0.0, yaw) is None


def test_two_equal_cartons_are_ambiguous(detector, view, scene):
    image = view.rectify(ArrayImage(*scene.render(0.5, -0.3, 0.0)))
    twin = view.rectify(ArrayImage(*scene.render(0.5, 0.3, 0.0)))
    half = image.grey.shape[1] // 2
    both = np.hstack([image.grey[:, :half], twin.grey[:, half:]])
    assert detector.detect(both) is None


def test_a_picture_of_the_target_at_another_height_gives_nothing(detector, view, scene):
    """A poster on the belt, 80 mm below the face; without depth it cannot be told."""
    image = view.rectify(ArrayImage(*scene.render(0.5, 0.0, 0.4)))
    seen = image.grey, image.visibility
    assert detector.detect(*seen, image.height_m) is not None
    assert detector.detect(*seen, np.full_like(image.height_m, -0.08)) is None
    assert detector.detect(*seen, np.full_like(image.height_m, np.nan)) is not None


def test_a_rival_at_another_height_is_no_rival(detector, view, scene):
    image = view.rectify(ArrayImage(*scene.render(0.5, -0.3, 0.0)))
    twin = view.rectify(ArrayImage(*scene.render(0.5, 0.3, 0.0)))
    half = image.grey.shape[1] // 2
    both = np.hstack([image.grey[:, :half], twin.grey[:, half:]])
    height_m = np.hstack([image.height_m[:, :half], np.full_like(image.height_m[:, half:], -0.08)])
    assert detector.detect(both, None, height_m) is not None


def test_black_and_hidden_images_give_nothing(detector, view):
    black = np.zeros(view.shape_px, np.uint8)
    assert detector.detect(black) is None
    noise = np.random.default_rng(0).integers(0, 255, view.shape_px, dtype=np.uint8)
    assert detector.detect(noise, np.zeros(view.shape_px, np.uint8)) is None
    assert detector.detect(noise) is None


def test_mostly_out_of_view_is_not_a_detection(detector, view, scene):
    assert find(detector, view, scene, 0.5, -0.86, 1.57) is None


@pytest.mark.parametrize(
    ("field", "value"),
    [("rotation_count", 7), ("reduction", 0), ("min_ncc", 1.5), ("max_height_m", 0.0)],
)
def test_bad_settings_are_refused(field, value):
    with pytest.raises(ValueError, match=field):
        DetectionConfig(**{field: value})
