import fruits
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker.apple.attitude import axis_error_deg, unit
from tracker.apple.axial_filter import AxialFilter, axial_mean
from tracker.apple.next_view import looking_at
from tracker.apple.single_view import AxisMeasurement, Method, SingleViewConfig, measure


def offset_measurement(axis, sigma=0.05):
    information = (np.eye(3) - np.outer(axis, axis)) / sigma**2
    return AxisMeasurement(Method.OFFSET, axis, axis, information)


def random_axes(seed, count):
    rng = np.random.default_rng(seed)
    return unit(np.array([0.2, -0.5, 0.8]) + 0.05 * rng.standard_normal((count, 3)))


@given(st.integers(0, 1000))
def test_the_order_of_images_does_not_matter(seed):
    measurements = [offset_measurement(axis) for axis in random_axes(seed, 5)]
    forward, backward = axial_mean(measurements), axial_mean(measurements[::-1])
    np.testing.assert_allclose(forward.axis, backward.axis, atol=1e-10)
    np.testing.assert_allclose(forward.covariance, backward.covariance, atol=1e-10)


def test_equal_images_shrink_the_uncertainty():
    axis = unit(np.array([0.1, 0.2, 1.0]))
    fused = axial_mean([offset_measurement(axis, 0.05)] * 4)
    np.testing.assert_allclose(fused.axis, axis, atol=1e-12)
    values = np.linalg.eigvalsh(fused.covariance)
    np.testing.assert_allclose(values, [0.0, 0.025**2, 0.025**2], rtol=1e-6, atol=1e-12)


def test_an_axis_and_its_opposite_are_the_same_evidence():
    axis = unit(np.array([0.1, 0.2, 1.0]))
    fused = axial_mean([offset_measurement(s * axis) for s in (1.0, -1.0, 1.0)])
    np.testing.assert_allclose(fused.axis, axis, atol=1e-12)


def test_two_views_from_the_side_find_a_leaning_axis_that_neither_can_see():
    """Method 1 is blind along its line of sight; planes of two views meet in the axis."""
    fruit = fruits.apple(fruits.direction(20.0, 40.0))
    config = SingleViewConfig(tilt_sigma_rad=10.0)
    views = [
        measure(
            fruits.sighting(
                fruit, looking_at(fruits.CENTRE_M, fruits.CENTRE_M - back), calyx_px=None
            ),
            config,
        )
        for back in (np.array([0.4, 0.0, 0.0]), np.array([0.0, 0.4, 0.0]))
    ]
    assert min(axis_error_deg(view.axis, fruit.axis) for view in views) > 10.0
    assert axis_error_deg(axial_mean(views).axis, fruit.axis) < 0.1


def test_what_is_forgotten_counts_less():
    old, new = random_axes(1, 2)
    fused = AxialFilter(retained=0.01)
    fused.update(offset_measurement(old))
    fused.update(offset_measurement(new))
    assert axis_error_deg(fused.axis, new) < 0.05 * axis_error_deg(old, new)


def test_before_the_first_image_there_is_no_axis():
    with pytest.raises(ValueError, match="no image"):
        _ = AxialFilter().axis
    with pytest.raises(ValueError, match=r"retained must be in \(0, 1\], got 0"):
        AxialFilter(retained=0)
