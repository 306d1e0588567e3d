import math

import fruits
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker.apple.attitude import PAPER_FROM_OPENCV, angles_deg, axis_error_deg, unit
from tracker.apple.next_view import looking_at
from tracker.apple.single_view import (
    Method,
    SingleViewConfig,
    inertia_axis,
    measure,
    offset_axis,
)
from tracker.apple.view import CameraPose, FruitStatus, FruitView, Sighting

FRONT = looking_at(fruits.CENTRE_M, fruits.CENTRE_M - [0.4, 0.0, 0.0])
UP = np.array([0.0, -1.0, 0.0])
"""In OpenCV's camera."""


def view(**changes):
    ellipse = {
        "status": FruitStatus.FOUND,
        "centre_px": np.array([320.0, 240.0]),
        "semi_axes_px": np.array([60.0, 50.0]),
        "major_angle_rad": 0.0,
    }
    return FruitView(**(ellipse | changes))


@pytest.mark.parametrize(
    ("alpha_deg", "published"),
    [(44, (44, 134, 90)), (16, (16, 106, 90)), (-30, (30, 60, 90)), (0, (0, 90, 90))],
)
def test_method_1_as_printed(alpha_deg, published):
    """Both lines of Eq. (1); the first two are camera columns of Table 1."""
    seen = view(major_angle_rad=math.radians(-alpha_deg) % math.pi)
    axis = PAPER_FROM_OPENCV @ inertia_axis(seen, fruits.K, UP, "paper")
    np.testing.assert_allclose(angles_deg(axis), published, atol=1e-6)


def printed_angles(dx, dy, length):
    """Eq. (2) of the paper, word for word."""
    dz = math.sqrt(length**2 - dx**2 - dy**2)
    return [
        math.degrees(math.acos((p**2 + length**2 - q**2 - r**2) / (2.0 * p * length)))
        for p, q, r in ((dx, dz, dy), (dy, dz, dx), (dz, dx, dy))
    ]


@given(st.floats(0.05, 0.6), st.floats(0.05, 0.6))
def test_method_2_as_printed(dx, dy):
    """Offsets up and to the right from the calyx to the middle, in half heights."""
    config_aspect, major = 0.9, 60.0
    length = config_aspect * major
    calyx = np.array([320.0, 240.0]) - length * np.array([dy, -dx])
    axis = offset_axis(view(calyx_px=calyx), fruits.K, config_aspect, "paper")
    np.testing.assert_allclose(
        angles_deg(PAPER_FROM_OPENCV @ axis), printed_angles(dx, dy, 1.0), atol=1e-6
    )


def test_method_2_where_the_printed_formula_divides_by_zero():
    axis = offset_axis(view(calyx_px=np.array([320.0, 240.0])), fruits.K, 0.9, "paper")
    np.testing.assert_allclose(axis, [0.0, 0.0, 1.0])


@pytest.mark.parametrize("form", ["paper", "perspective"])
def test_a_calyx_on_the_rim_gives_an_axis_across_the_view(form):
    seen = view(calyx_px=np.array([320.0, 300.0]))
    axis = offset_axis(seen, fruits.K, 0.85, form)
    assert np.linalg.norm(axis) == pytest.approx(1.0)
    assert axis[1] < -0.95


@given(st.integers(0, 2**32 - 1))
def test_method_1_is_exact_in_perspective_for_an_axis_across_the_line_of_sight(seed):
    rng = np.random.default_rng(seed)
    place = fruits.CENTRE_M + rng.uniform(0.15, 0.6) * unit([-1.0, *rng.uniform(-0.5, 0.5, 2)])
    pose = looking_at(fruits.CENTRE_M + rng.uniform(-0.02, 0.02, 3), place)
    ray = unit(fruits.CENTRE_M - place)
    axis = unit(np.cross(ray, rng.standard_normal(3)))
    axis *= 1.0 if axis[2] >= 0.0 else -1.0
    found = measure(fruits.sighting(fruits.apple(axis), pose, calyx_px=None))
    assert found.method is Method.INERTIA
    assert axis_error_deg(found.axis, axis) == pytest.approx(0.0, abs=1e-4)


def test_the_bias_of_method_1_is_the_tilt_along_the_line_of_sight():
    fruit = fruits.apple(fruits.direction(20.0, 0.0))
    for form in ("paper", "perspective"):
        found = measure(fruits.sighting(fruit, FRONT, calyx_px=None), SingleViewConfig(form=form))
        assert axis_error_deg(found.axis, fruit.axis) == pytest.approx(20.0, abs=0.1)
        ray = np.array([1.0, 0.0, 0.0])
        assert ray @ found.information @ ray < 0.05 * np.trace(found.information)


@pytest.mark.parametrize("aside_deg", [5.0, 20.0, 40.0])
def test_method_2_is_better_in_perspective_when_the_camera_is_near(aside_deg):
    angle = math.radians(aside_deg)
    fruit = fruits.apple((math.cos(angle), 0.0, math.sin(angle)))
    near = looking_at(
        fruits.CENTRE_M + np.array([0.0, 0.02, -0.02]), fruits.CENTRE_M - [0.22, 0.0, 0.0]
    )
    errors = {
        form: axis_error_deg(
            measure(fruits.sighting(fruit, near), SingleViewConfig(form=form, aspect=0.85)).axis,
            fruit.axis,
        )
        for form in ("paper", "perspective")
    }
    assert errors["perspective"] < 0.01
    assert errors["paper"] > 3.0


def test_the_form_as_printed_is_right_far_away():
    fruit = fruits.apple((math.cos(0.4), 0.0, math.sin(0.4)))
    far = looking_at(fruits.CENTRE_M, fruits.CENTRE_M - [20.0, 0.0, 0.0])
    found = measure(fruits.sighting(fruit, far), SingleViewConfig(form="paper", aspect=0.85))
    assert found.method is Method.OFFSET
    assert axis_error_deg(found.axis, fruit.axis) < 0.3


@pytest.mark.parametrize("form", ["paper", "perspective"])
def test_the_robots_frame(form):
    """Turning camera and fruit together turns the answer with them."""
    fruit = fruits.apple((math.cos(0.4), 0.0, math.sin(0.4)))
    seen = fruits.sighting(fruit, FRONT)
    turn = fruits.rotation([0.3, -0.5, 0.7])
    turned = Sighting(seen.view, seen.K, CameraPose(turn @ FRONT.rotation, turn @ FRONT.position_m))
    config = SingleViewConfig(form=form)
    np.testing.assert_allclose(
        measure(turned, config).axis, turn @ measure(seen, config).axis, atol=1e-9
    )


@pytest.mark.parametrize("status", [s for s in FruitStatus if s is not FruitStatus.FOUND])
def test_without_a_fruit_there_is_no_answer(status):
    assert measure(Sighting(FruitView(status), fruits.K, FRONT)) is None
    with pytest.raises(ValueError, match=status.value):
        inertia_axis(FruitView(status), fruits.K, UP, "perspective")


def test_settings_are_checked():
    with pytest.raises(ValueError, match="form must be one of paper, perspective; got 'print'"):
        SingleViewConfig(form="print")
    with pytest.raises(ValueError, match="aspect must be a positive number, got 0"):
        SingleViewConfig(aspect=0)
    with pytest.raises(ValueError, match="method 2 needs"):
        offset_axis(view(), fruits.K, 0.9, "paper")
