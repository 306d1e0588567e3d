"""Laws of the group, near-identity samples included."""

import numpy as np
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

from tracker.affine import aff2, aff2_loops

SCALES = st.sampled_from([0.0, 1e-12, 1e-7, 1e-4, 1e-2, 0.3, 1.0])


@st.composite
def tangents(draw):
    scale = draw(SCALES)
    seed = draw(st.integers(0, 2**32 - 1))
    return scale * np.clip(np.random.default_rng(seed).standard_normal(6), -1.4, 1.4)


def hat(e):
    """(3, 3) matrix of a tangent vector (6,). [IGPF2021] Eq (5)."""
    return np.array([[e[0] + e[1], e[3] - e[2], e[4]], [e[3] + e[2], e[0] - e[1], e[5]], [0, 0, 0]])


def vee(M):
    (a, b, x), (c, d, y), _ = M
    return np.array([0.5 * (a + d), 0.5 * (a - d), 0.5 * (c - b), 0.5 * (c + b), x, y])


def right_jacobian(e):
    """(6, 6) Jr with `exp(e + d) = exp(e) exp(Jr d)` to first order in d.

    Series `sum_n (-ad e)^n / (n + 1)!`, exact to float64 for |e| up to about 3.
    """
    ad = np.column_stack([vee(hat(e) @ hat(f) - hat(f) @ hat(e)) for f in np.eye(6)])
    terms = [np.eye(6)]
    for n in range(1, 24):
        terms.append(-terms[-1] @ ad / (n + 1))
    return np.sum(terms, axis=0)


@njit
def log_det_right_jacobian(e):
    """As compiled code calls it."""
    return aff2_loops.log_det_right_jacobian(e)


@given(tangents())
def test_exp_equals_the_general_matrix_exponential(e):
    np.testing.assert_allclose(aff2.exp(e), scipy.linalg.expm(hat(e)), atol=1e-12)


@given(tangents())
def test_log_equals_the_general_matrix_logarithm(e):
    X = aff2.exp(e)
    expected = scipy.linalg.logm(X)
    np.testing.assert_allclose(hat(aff2.log(X)), expected, atol=1e-7)


@given(tangents())
def test_log_inverts_exp(e):
    np.testing.assert_allclose(aff2.log(aff2.exp(e)), e, atol=1e-11)


@given(tangents(), tangents(), tangents())
def test_group_axioms(a, b, c):
    X, Y, Z = aff2.exp(a), aff2.exp(b), aff2.exp(c)
    np.testing.assert_allclose((X @ Y) @ Z, X @ (Y @ Z), rtol=1e-9)
    np.testing.assert_allclose(X @ aff2.inverse(X), np.eye(3), atol=1e-10)
    np.testing.assert_allclose(aff2.exp(-a), aff2.inverse(X), atol=1e-10)


@given(tangents(), tangents())
def test_right_jacobian_is_the_derivative_of_exp(e, d):
    h = 1e-6
    moved = aff2.log(aff2.inverse(aff2.exp(e - h * d)) @ aff2.exp(e + h * d)) / (2 * h)
    np.testing.assert_allclose(moved, right_jacobian(e) @ d, atol=1e-6)


@given(tangents())
def test_closed_form_of_the_volume_equals_the_determinant(e):
    _, expected = np.linalg.slogdet(right_jacobian(e))
    np.testing.assert_allclose(log_det_right_jacobian(e), expected, atol=1e-9)


@given(tangents())
def test_polar_parameters_round_trip(e):
    X = aff2.exp(e)
    np.testing.assert_allclose(aff2.from_polar(aff2.polar(X)), X, atol=1e-10)


@settings(max_examples=30)
@given(tangents(), st.integers(0, 2**32 - 1))
def test_mean_is_equivariant_and_stays_in_the_group(e, seed):
    rng = np.random.default_rng(seed)
    X = aff2.exp(0.2 * rng.standard_normal((20, 6)))
    w = rng.random(20)
    w /= w.sum()
    Y = aff2.exp(e)
    np.testing.assert_allclose(
        aff2.mean(Y @ X, w, iterations=8), Y @ aff2.mean(X, w, iterations=8), atol=1e-6
    )


def test_functions_broadcast_over_leading_axes():
    e = np.random.default_rng(0).standard_normal((2, 5, 6)) * 0.3
    X = aff2.exp(e)
    assert X.shape == (2, 5, 3, 3)
    np.testing.assert_allclose(X[1, 3], aff2.exp(e[1, 3]))
    np.testing.assert_allclose(aff2.log(X)[1, 3], aff2.log(X[1, 3]))
    for a, b in ((X, X[0, 0]), (X[0, 0], X), (X[:, :1], X[:1]), (X[0, 0], X[1, 1])):
        expected = aff2.log(aff2.inverse(a) @ b)
        np.testing.assert_allclose(aff2.difference(a, b), expected, atol=1e-12)
        np.testing.assert_allclose(aff2.perturb(a, expected), np.broadcast_to(b, (a @ b).shape))


def test_no_logarithm_gives_nan_and_invalid_elements_are_named():
    mirror = np.diag([-1.0, 1.0, 1.0])
    broken = np.eye(3)
    broken[0, 2] = np.nan
    stack = np.stack([np.eye(3), mirror, broken, np.diag([-2.0, -3.0, 1.0])])
    assert aff2.is_valid(stack).tolist() == [True, False, False, True]
    logs = aff2.log(stack)
    assert np.isfinite(logs[0]).all()
    assert not np.isfinite(logs[1]).all()
    assert not np.isfinite(logs[3]).all()


def test_a_singular_element_gives_nan_and_no_exception():
    singular = np.zeros((3, 3))
    assert np.isnan(aff2.difference(singular, np.eye(3))).all()
    assert not np.isfinite(aff2.log(singular)).any()
