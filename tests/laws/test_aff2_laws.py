"""Laws of the group, near-identity samples included."""

import numpy as np
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st

from tracker.affine import aff2

SCALES = st.sampled_from([0.0, 1e-12, 1e-7, 1e-4, 1e-2, 0.3, 1.0])


@st.composite
def tangents(draw):
    scale = draw(SCALES)
    seed = draw(st.integers(0, 2**32 - 1))
    return scale * np.clip(np.random.default_rng(seed).standard_normal(6), -1.4, 1.4)


@given(tangents())
def test_exp_equals_the_general_matrix_exponential(e):
    np.testing.assert_allclose(aff2.exp(e), scipy.linalg.expm(aff2.hat(e)), atol=1e-12)


@given(tangents())
def test_log_equals_the_general_matrix_logarithm(e):
    X = aff2.exp(e)
    expected = scipy.linalg.logm(X)
    np.testing.assert_allclose(aff2.hat(aff2.log(X)), expected, atol=1e-7)


@given(tangents())
def test_log_inverts_exp(e):
    np.testing.assert_allclose(aff2.log(aff2.exp(e)), e, atol=1e-11)


@given(tangents(), tangents(), tangents())
def test_group_axioms(a, b, c):
    X, Y, Z = aff2.exp(a), aff2.exp(b), aff2.exp(c)
    np.testing.assert_allclose(
        aff2.compose(aff2.compose(X, Y), Z), aff2.compose(X, aff2.compose(Y, Z)), rtol=1e-9
    )
    np.testing.assert_allclose(aff2.compose(X, aff2.inverse(X)), np.eye(3), atol=1e-10)
    np.testing.assert_allclose(aff2.exp(-a), aff2.inverse(X), atol=1e-10)


@given(tangents())
def test_hat_and_vee_are_inverse(e):
    np.testing.assert_allclose(aff2.vee(aff2.hat(e)), e, rtol=1e-9, atol=1e-20)


@given(tangents(), tangents())
def test_adjoint_moves_a_perturbation_across(a, b):
    X = aff2.exp(a)
    left = X @ aff2.exp(b)
    right = aff2.exp(aff2.adjoint(X) @ b) @ X
    np.testing.assert_allclose(left, right, atol=1e-8 * (1 + np.abs(left).max()))


@given(tangents(), tangents())
def test_right_jacobian_is_the_derivative_of_exp(e, d):
    h = 1e-6
    moved = aff2.log(aff2.inverse(aff2.exp(e - h * d)) @ aff2.exp(e + h * d)) / (2 * h)
    np.testing.assert_allclose(moved, aff2.right_jacobian(e) @ d, atol=1e-6)


@given(tangents())
def test_closed_form_of_the_volume_equals_the_determinant(e):
    _, expected = np.linalg.slogdet(aff2.right_jacobian(e))
    np.testing.assert_allclose(aff2.log_det_right_jacobian(e), expected, atol=1e-9)


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
    assert aff2.right_jacobian(e).shape == (2, 5, 6, 6)
    assert aff2.adjoint(X).shape == (2, 5, 6, 6)


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
