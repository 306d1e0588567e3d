"""As compiled code calls them; from Python they are not called anywhere."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

from tracker.bearing_only import small_matrices

sizes = st.integers(1, 7)


@njit
def product(A, B):
    return small_matrices.product(A, B)


@njit
def sandwich(A, P):
    return small_matrices.sandwich(A, P)


@njit
def inverse_and_determinant(S):
    return small_matrices.inverse_and_determinant(S)


@njit
def dots(a):
    return small_matrices.dot(a, a), small_matrices.dot(a, (4.0, 5.0, 6.0))


@given(sizes, sizes, sizes, st.integers(0, 2**16))
def test_products_are_those_of_numpy(n, k, m, seed):
    rng = np.random.default_rng(seed)
    A, B, P = (rng.standard_normal(shape) for shape in ((n, k), (k, m), (k, k)))
    np.testing.assert_allclose(product(A, B), A @ B, atol=1e-12)
    np.testing.assert_allclose(product(B.T, A.T), (A @ B).T, atol=1e-12)
    np.testing.assert_allclose(sandwich(A, P), A @ P @ A.T, atol=1e-12)


@given(st.integers(0, 2**16))
def test_an_inverse_undoes(seed):
    S = np.random.default_rng(seed).standard_normal((2, 2)) + 5.0 * np.eye(2)
    inverse, determinant = inverse_and_determinant(S)
    np.testing.assert_allclose(inverse @ S, np.eye(2), atol=1e-12)
    assert np.isclose(determinant, np.linalg.det(S))


def test_a_dot_takes_arrays_and_tuples():
    assert dots(np.array([1.0, 2.0, 3.0])) == (14.0, 32.0)
