import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker.apple.attitude import (
    PAPER_FROM_OPENCV,
    angle_between_deg,
    angles_deg,
    axis_error_deg,
    axis_of_angles,
    folded_deg,
    opencv_rotation,
    require_unit,
    rotation_of_fixed_angles,
    tangent_basis,
    unit,
)


@st.composite
def axes(draw):
    return unit(np.random.default_rng(draw(st.integers(0, 2**32 - 1))).standard_normal(3))


@given(axes())
def test_angles_and_axes_are_inverse(axis):
    np.testing.assert_allclose(axis_of_angles(angles_deg(axis)), axis, atol=1e-9)


def test_published_attitude_by_hand():
    np.testing.assert_allclose(axis_of_angles(np.array([90.0, 90.0, 0.0])), [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(angles_deg(np.array([0.0, -1.0, 0.0])), [90.0, 180.0, 90.0])


def test_angles_that_belong_to_no_axis_are_refused():
    with pytest.raises(ValueError, match=r"\[10.0, 10.0, 10.0\]"):
        axis_of_angles(np.array([10.0, 10.0, 10.0]))
    with pytest.raises(ValueError, match="length 1, got length 2"):
        angles_deg(np.array([2.0, 0.0, 0.0]))
    with pytest.raises(ValueError, match="three finite components"):
        require_unit(np.array([np.nan, 0.0, 1.0]))
    with pytest.raises(ValueError, match="finite and not zero"):
        unit(np.zeros(3))


def test_folding_loses_the_sign():
    np.testing.assert_allclose(folded_deg(np.array([98.0, 82.0, 180.0])), [82.0, 82.0, 0.0])


def test_errors_of_vectors_and_of_axes():
    x, y = np.eye(3)[:2]
    assert angle_between_deg(x, -x) == pytest.approx(180.0)
    assert axis_error_deg(x, -x) == pytest.approx(0.0)
    assert axis_error_deg(x, unit(-x - y)) == pytest.approx(45.0)
    tiny = unit(x + 1e-9 * y)
    assert angle_between_deg(x, tiny) == pytest.approx(np.degrees(1e-9), rel=1e-6)


def test_fixed_angles_turn_about_x_then_y_then_z():
    """90 degrees about x send y to z, then those about y z to x, then those about z x to y."""
    R = rotation_of_fixed_angles(np.array([90.0, 90.0, 90.0]))
    np.testing.assert_allclose(R @ [0.0, 1.0, 0.0], [0.0, 1.0, 0.0], atol=1e-12)
    one = rotation_of_fixed_angles(np.array([0.0, 0.0, 30.0]))
    np.testing.assert_allclose(one @ [1.0, 0.0, 0.0], [np.sqrt(0.75), 0.5, 0.0], atol=1e-12)


@given(st.lists(st.floats(-180.0, 180.0), min_size=3, max_size=3))
def test_fixed_angles_give_rotations(angles):
    R = rotation_of_fixed_angles(np.array(angles))
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0)


def test_the_cameras_axes():
    """OpenCV's x is the paper's y, its -y the paper's x."""
    np.testing.assert_allclose(PAPER_FROM_OPENCV @ [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    np.testing.assert_allclose(PAPER_FROM_OPENCV @ [0.0, -1.0, 0.0], [1.0, 0.0, 0.0])
    np.testing.assert_allclose(opencv_rotation(np.eye(3)), PAPER_FROM_OPENCV)
    assert np.linalg.det(PAPER_FROM_OPENCV) == pytest.approx(1.0)


@given(axes())
def test_a_tangent_basis_is_orthonormal(axis):
    frame = np.column_stack([tangent_basis(axis), axis])
    np.testing.assert_allclose(frame.T @ frame, np.eye(3), atol=1e-12)
