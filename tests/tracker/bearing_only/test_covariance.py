"""The sparse products against the dense ones that they stand for."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracker.bearing_only import covariance
from tracker.bearing_only.covariance import POSE, correct, innovation_blocks, project, selected

NOISE_STD = 3.0


def problem(sizes, seen, seed):
    """Derivatives, starts, P and the dense H for landmarks of `sizes`, of which some are seen."""
    rng = np.random.default_rng(seed)
    starts = POSE + np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(np.int64)
    N = POSE + sum(sizes)
    root = rng.standard_normal((N, N))
    by_pose = rng.standard_normal((len(seen), 2, 6))
    by_feature = np.zeros((len(seen), 2, 6))
    H = np.zeros((2 * len(seen), N))
    for i, landmark in enumerate(seen):
        size, start = sizes[landmark], starts[landmark]
        by_feature[i, :, :size] = rng.standard_normal((2, size))
        H[2 * i : 2 * i + 2, :POSE] = by_pose[i]
        H[2 * i : 2 * i + 2, start : start + size] = by_feature[i, :, :size]
    return (by_pose, by_feature, starts[list(seen)]), root @ root.T / N, H


landmarks = st.lists(st.sampled_from([3, 6]), min_size=1, max_size=30).flatmap(
    lambda sizes: st.tuples(
        st.just(sizes),
        st.lists(st.integers(0, len(sizes) - 1), min_size=1, unique=True),
        st.integers(0, 2**16),
    )
)


@settings(max_examples=50)
@given(landmarks)
def test_products_equal_the_dense_ones(case):
    seen, P, H = problem(*case)
    HP, S = project(*seen, P, NOISE_STD)
    dense = H @ P @ H.T + NOISE_STD**2 * np.eye(len(H))
    np.testing.assert_allclose(HP, H @ P, atol=1e-10)
    np.testing.assert_allclose(np.tril(S), np.tril(dense), atol=1e-10)
    blocks = innovation_blocks(*seen, P, NOISE_STD)
    for i, block in enumerate(blocks):
        np.testing.assert_allclose(block, dense[2 * i : 2 * i + 2, 2 * i : 2 * i + 2], atol=1e-10)


@settings(max_examples=50)
@given(landmarks)
def test_correction_is_that_of_a_kalman_filter(case):
    seen, P, H = problem(*case)
    residual = np.random.default_rng(case[2]).standard_normal(len(H))
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + NOISE_STD**2 * np.eye(len(H)))
    expected = P - K @ H @ P
    error = correct(P, *project(*seen, P, NOISE_STD), residual)
    np.testing.assert_allclose(error, K @ residual, atol=1e-10)
    np.testing.assert_allclose(P, expected, atol=1e-10)
    np.testing.assert_array_equal(P, P.T)


def test_a_state_larger_than_a_block_stays_symmetric():
    N = 3 * covariance._BLOCK + 5
    sizes = [3] * ((N - POSE) // 3)
    seen, P, _ = problem(sizes, range(0, len(sizes), 2), 4)
    correct(P, *project(*seen, P, NOISE_STD), np.ones(2 * len(seen[2])))
    np.testing.assert_array_equal(P, P.T)


def test_an_impossible_covariance_is_refused():
    with pytest.raises(np.linalg.LinAlgError, match="positive definite"):
        correct(np.eye(8), np.ones((2, 8)), np.diag([1.0, -1.0]), np.zeros(2))


def test_a_covariance_that_blas_would_copy_is_refused():
    P = np.asfortranarray(np.arange(64.0).reshape(8, 8))
    with pytest.raises(ValueError, match="C order"):
        correct(P, np.ones((2, 8)), np.eye(2), np.zeros(2))


def test_selection_is_that_of_index_arrays():
    P, kept = np.random.default_rng(2).standard_normal((9, 9)), np.array([0, 3, 4, 8])
    np.testing.assert_array_equal(selected(P, kept), P[np.ix_(kept, kept)])
