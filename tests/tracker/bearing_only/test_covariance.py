"""The covariance that is kept by half and changed in place, against dense matrices."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracker.bearing_only.covariance import JointCovariance
from tracker.bearing_only.landmarks import POSE

NOISE_STD = 3.0


def dense(covariance):
    return covariance.blocks(np.arange(len(covariance)))


def random_covariance(N, rng):
    """One of N numbers, at least the pose's, by way of `append`; and the same in full."""
    root = rng.standard_normal((POSE, POSE))
    P = JointCovariance(root @ root.T)
    while len(P) < N:
        m = min(N - len(P), 9)
        J, own = rng.standard_normal((m, POSE)), rng.standard_normal((m, m))
        before = dense(P)
        P.append(J, (own @ own.T)[None])
        with_pose = J @ before[:POSE]
        after = np.block([[before, with_pose.T],
                          [with_pose, with_pose[:, :POSE] @ J.T + own @ own.T]])  # fmt: skip
        np.testing.assert_allclose(dense(P), after, atol=1e-10)
    return P, dense(P)


def problem(sizes, seen, seed):
    """Derivatives and starts, the covariance, the same in full, and the dense H."""
    rng = np.random.default_rng(seed)
    starts = POSE + np.cumsum([0, *sizes[:-1]])
    N = POSE + sum(sizes)
    by_pose = rng.standard_normal((len(seen), 2, 6))
    by_feature = np.zeros((len(seen), 2, 6))
    H = np.zeros((2 * len(seen), N))
    for i, landmark in enumerate(seen):
        size, start = sizes[landmark], starts[landmark]
        by_feature[i, :, :size] = rng.standard_normal((2, size))
        H[2 * i : 2 * i + 2, :POSE] = by_pose[i]
        H[2 * i : 2 * i + 2, start : start + size] = by_feature[i, :, :size]
    return (by_pose, by_feature, starts[list(seen)]), *random_covariance(N, rng), H


landmarks = st.lists(st.sampled_from([3, 6]), min_size=1, max_size=30).flatmap(
    lambda sizes: st.tuples(
        st.just(sizes),
        st.lists(st.integers(0, len(sizes) - 1), min_size=1, unique=True),
        st.integers(0, 2**16),
    )
)


@settings(max_examples=50)
@given(landmarks)
def test_innovations_are_those_of_the_dense_matrix(case):
    seen, P, full, H = problem(*case)
    S = H @ full @ H.T + NOISE_STD**2 * np.eye(len(H))
    blocks = P.innovation_blocks(seen, NOISE_STD)
    for i, block in enumerate(blocks):
        np.testing.assert_allclose(block, S[2 * i : 2 * i + 2, 2 * i : 2 * i + 2], rtol=1e-9)


@settings(max_examples=50)
@given(landmarks)
def test_correction_is_that_of_a_kalman_filter(case):
    seen, P, full, H = problem(*case)
    residual = np.random.default_rng(case[2]).standard_normal(len(H))
    K = full @ H.T @ np.linalg.inv(H @ full @ H.T + NOISE_STD**2 * np.eye(len(H)))
    error = P.correct(seen, residual, NOISE_STD)
    scale = np.abs(full).max()
    np.testing.assert_allclose(error, K @ residual, atol=1e-9 * scale)
    np.testing.assert_allclose(dense(P), full - K @ H @ full, atol=1e-9 * scale)


def test_an_impossible_covariance_is_refused_and_left_as_it_was():
    P = JointCovariance(np.diag([-9.0, 1.0, 1.0, 1.0, 1.0, 1.0]))
    P.append(np.zeros((3, POSE)), np.eye(3)[None])
    by_pose = np.ones((1, 2, 6))
    before = dense(P)
    with pytest.raises(np.linalg.LinAlgError, match="positive definite"):
        P.correct((by_pose, np.zeros((1, 2, 6)), np.array([POSE])), np.zeros(2), 0.1)
    np.testing.assert_array_equal(dense(P), before)


def test_the_pose_moves_and_its_relation_to_the_landmarks_with_it():
    rng = np.random.default_rng(1)
    P, full = random_covariance(20, rng)
    F, Q = rng.standard_normal((6, 6)), np.diag(rng.uniform(0.1, 1.0, 6))
    P.move_pose(F, Q)
    all_F, all_Q = np.eye(20), np.zeros((20, 20))
    all_F[:6, :6], all_Q[:6, :6] = F, Q
    np.testing.assert_allclose(dense(P), all_F @ full @ all_F.T + all_Q, atol=1e-10)
    np.testing.assert_array_equal(P.pose, dense(P)[:6, :6])


@settings(max_examples=30)
@given(st.lists(st.booleans(), min_size=1, max_size=8), st.integers(0, 2**16))
def test_landmarks_get_coordinates_and_what_they_leave_is_dropped(is_chosen, seed):
    rng = np.random.default_rng(seed)
    N = POSE + 6 * len(is_chosen)
    P, full = random_covariance(N, rng)
    chosen = np.flatnonzero(is_chosen)
    starts, J = POSE + 6 * chosen, rng.standard_normal((len(chosen), 3, 6))
    T, is_kept = np.eye(N), np.ones(N, bool)
    for start, block in zip(starts, J, strict=True):
        T[start : start + 3] = 0.0
        T[start : start + 3, start : start + 6] = block
        is_kept[start + 3 : start + 6] = False
    P.to_coordinates(starts, J)
    P.keep(np.flatnonzero(is_kept))
    expected = (T @ full @ T.T)[np.ix_(is_kept, is_kept)]
    np.testing.assert_allclose(dense(P), expected, atol=1e-10)
    np.testing.assert_array_equal(P.variances(np.arange(len(P))), np.diag(dense(P)))
