import fruits
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker.apple.attitude import axis_error_deg, unit
from tracker.apple.filters import (
    AxialFilter,
    PointFilterConfig,
    kalman_estimates,
    particle_estimates,
)
from tracker.apple.next_view import looking_at
from tracker.apple.single_view import AxisMeasurement, Method, SingleViewConfig, measure


def measurements(seed, count=6):
    rng = np.random.default_rng(seed)
    return unit(np.array([0.3, 0.2, 0.9]) + 0.1 * rng.standard_normal((count, 3)))


def test_the_exact_filter_by_hand():
    """σ = 1, q = 1, P₁ = 0: the gains are 1 / 2, then (1/2 + 1) / (1/2 + 2) = 3 / 5."""
    config = PointFilterConfig(measurement_sigma_cm=1.0, walk_sigma_cm=1.0)
    measured = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]])
    expected = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.8, 0.6, 0.0]]
    np.testing.assert_allclose(kalman_estimates(measured, config), expected, atol=1e-12)


def test_many_particles_approach_the_exact_filter():
    measured = measurements(0)
    config = PointFilterConfig(particle_count=200_000)
    estimates = particle_estimates(measured, config, np.random.default_rng(1))
    np.testing.assert_allclose(estimates, kalman_estimates(measured, config), atol=1e-3)


def test_few_particles_scatter_about_the_exact_filter():
    measured = measurements(2)
    runs = np.array(
        [
            particle_estimates(measured, PointFilterConfig(), np.random.default_rng(seed))
            for seed in range(200)
        ]
    )
    exact = kalman_estimates(measured, PointFilterConfig())
    error = (runs.mean(axis=0) - exact)[1:]
    limit = 5.0 * runs.std(axis=0)[1:] / np.sqrt(200) + 2e-3  # few particles are biased, too
    assert (np.abs(error) < limit).all()
    assert runs.std(axis=0)[1:].min() > 1e-4


@given(st.integers(0, 1000))
def test_all_begins_at_the_first_measurement(seed):
    measured = measurements(seed, count=2)
    estimates = particle_estimates(measured, PointFilterConfig(), np.random.default_rng(seed))
    np.testing.assert_allclose(estimates[0], measured[0])
    between = (estimates[1] - measured[0]) * (measured[1] - measured[0])
    assert between.sum() > 0.0 or np.abs(measured[1] - measured[0]).max() < 0.02


def test_coordinates_are_filtered_apart():
    """What the other coordinates measure changes nothing; a joint weight would."""
    first, second = measurements(3), measurements(4)
    second[:, 0] = first[:, 0]
    runs = [
        particle_estimates(m, PointFilterConfig(), np.random.default_rng(5))
        for m in (first, second)
    ]
    np.testing.assert_array_equal(runs[0][:, 0], runs[1][:, 0])
    assert not np.allclose(runs[0][:, 1], runs[1][:, 1])


def test_nothing_is_normalised():
    opposite = unit(np.array([[1.0, 0.0, 0.2], [-1.0, 0.0, 0.2]]))
    assert np.linalg.norm(kalman_estimates(opposite, PointFilterConfig())[-1]) < 0.95


def test_the_same_seed_gives_the_same_estimates():
    runs = [
        particle_estimates(measurements(6), PointFilterConfig(), np.random.default_rng(7))
        for _ in range(2)
    ]
    np.testing.assert_array_equal(*runs)


@pytest.mark.parametrize("run", [kalman_estimates, lambda m, c: particle_estimates(m, c, None)])
def test_bad_input_is_refused(run):
    with pytest.raises(ValueError, match=r"shape \(n, 3\), got \(4,\)"):
        run(np.zeros(4), PointFilterConfig())
    with pytest.raises(ValueError, match="finite"):
        run(np.full((2, 3), np.nan), PointFilterConfig())
    with pytest.raises(ValueError, match="walk_sigma_cm must be a positive number, got 0"):
        PointFilterConfig(walk_sigma_cm=0)
    with pytest.raises(ValueError, match="particle_count must be 1 or greater, got 0"):
        PointFilterConfig(particle_count=0)


def axial_mean(measurements):
    fused = AxialFilter()
    for measurement in measurements:
        fused.update(measurement)
    return fused


def offset_measurement(axis, sigma=0.05):
    information = (np.eye(3) - np.outer(axis, axis)) / sigma**2
    return AxisMeasurement(Method.OFFSET, axis, information)


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


def test_before_the_first_image_there_is_no_axis():
    with pytest.raises(ValueError, match="no image"):
        _ = AxialFilter().axis
