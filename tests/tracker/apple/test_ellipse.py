"""The robust ellipse on points of known ellipses."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker.apple.ellipse import fit_ellipse


def points_on(centre, semi_axes, angle, turns):
    c, s = np.cos(angle), np.sin(angle)
    local = np.stack([semi_axes[0] * np.cos(turns), semi_axes[1] * np.sin(turns)], axis=1)
    return np.array(centre) + local @ np.array([[c, s], [-s, c]])


def fitted(points, trusted=None):
    trusted = np.ones(len(points), bool) if trusted is None else trusted
    return fit_ellipse(points, trusted, noise_px=0.3, tolerance_px=1.5)


def angle_apart(first, second):
    return abs((first - second + np.pi / 2) % np.pi - np.pi / 2)


@given(
    st.floats(20.0, 150.0), st.floats(0.75, 0.97), st.floats(0.0, np.pi - 1e-3), st.floats(-50, 900)
)
def test_an_exact_ellipse_is_found_again(major, ratio, angle, u):
    points = points_on((u, 120.0), (major, ratio * major), angle, np.linspace(0, 2 * np.pi, 90))
    found = fitted(points)
    assert found is not None
    assert found.centre_px == pytest.approx([u, 120.0], abs=0.01)
    assert found.semi_axes_px == pytest.approx([major, ratio * major], abs=0.01)
    assert angle_apart(found.major_angle_rad, angle) < 0.01
    assert 0.0 <= found.major_angle_rad < np.pi
    assert found.is_inlier.all()


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.5, 2.9])
def test_points_inside_that_lie_on_something_in_front_do_not_bend_it(angle):
    rng = np.random.default_rng(0)
    turns = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)
    points = points_on((100.0, 80.0), (60.0, 52.0), angle, turns)
    cut = (turns > 1.0) & (turns < 2.6)
    chord = np.linspace(0.0, 1.0, cut.sum())[:, None]
    first, last = points[cut][0], points[cut][-1]
    points[cut] = (1.0 - chord) * first + chord * last
    points += 0.2 * rng.standard_normal(points.shape)
    found = fitted(points)
    assert found.centre_px == pytest.approx([100.0, 80.0], abs=0.5)
    assert found.semi_axes_px == pytest.approx([60.0, 52.0], abs=0.5)
    assert found.is_inlier[~cut].mean() > 0.95
    assert found.is_inlier[cut].mean() < 0.3


def test_the_covariance_is_that_of_repeated_fits():
    turns = np.linspace(0.0, 2.0 * np.pi, 150, endpoint=False)
    exact = points_on((100.0, 80.0), (60.0, 50.0), 0.7, turns)
    rng = np.random.default_rng(1)
    fits = [fitted(exact + 0.3 * rng.standard_normal(exact.shape)) for _ in range(200)]
    found = np.array([[*f.centre_px, *np.log(f.semi_axes_px), f.major_angle_rad] for f in fits])
    told = np.sqrt(np.diag(np.mean([f.covariance for f in fits], axis=0)))
    assert found.std(axis=0) == pytest.approx(told, rel=0.25)


@pytest.mark.parametrize(
    "points",
    [
        np.zeros((0, 2)),
        np.zeros((40, 2)),
        np.column_stack([np.arange(50.0), np.arange(50.0)]),
        points_on((0.0, 0.0), (60.0, 20.0), 0.0, np.linspace(0.0, 6.0, 90)),
    ],
    ids=["none", "one point", "a line", "too flat for a fruit"],
)
def test_what_is_no_outline_of_a_fruit_gives_none(points):
    assert fitted(points) is None
