import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tracker.bearing_only.small_matrices import dot, inverse_and_determinant, product, sandwich

sizes = st.integers(1, 7)


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
    a, b = np.array([1.0, 2.0, 3.0]), (4.0, 5.0, 6.0)
    assert dot(a, b) == 32.0
    assert dot(a, a) == 14.0
