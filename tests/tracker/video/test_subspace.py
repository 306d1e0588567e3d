import numpy as np
import pytest

from tracker.video.subspace import Subspace, SubspaceConfig


def patches(rng, directions, count):
    """Zero-mean patches around a fixed one that vary along `directions` (k, n)."""
    return rng.normal(0, [3.0, 1.0], (count, 2)) @ directions


@pytest.fixture
def directions():
    rng = np.random.default_rng(5)
    raw = rng.normal(size=(2, 60))
    raw -= raw.mean(axis=1, keepdims=True)
    return np.linalg.qr(raw.T)[0].T


def test_the_basis_is_that_of_all_patches_at_once(directions):
    """Without forgetting, batch after batch gives the principal components of the whole."""
    rng = np.random.default_rng(0)
    mean = rng.normal(size=60)
    mean -= mean.mean()
    data = mean + patches(rng, directions, 40)
    subspace = Subspace(SubspaceConfig(rank=2, batch=5, forgetting=1.0), data[0])
    for patch in data[1:36]:
        subspace.add(patch)
    seen = data[:36]
    rows = np.linalg.svd(seen - seen.mean(axis=0), full_matrices=False)[2][:2]
    overlap = np.linalg.svd(subspace.basis @ rows.T, compute_uv=False)
    np.testing.assert_allclose(overlap, 1.0, atol=1e-4)


def test_rows_stay_orthonormal_and_without_mean(directions):
    rng = np.random.default_rng(1)
    subspace = Subspace(SubspaceConfig(rank=3, batch=4), np.zeros(60))
    for patch in patches(rng, directions, 50) + 0.01 * rng.normal(size=(50, 60)):
        subspace.add(patch - patch.mean())
    assert subspace.basis.shape == (3, 60)
    np.testing.assert_allclose(subspace.basis @ subspace.basis.T, np.eye(3), atol=1e-5)
    np.testing.assert_allclose(subspace.basis.sum(axis=1), 0.0, atol=1e-4)


def test_patches_that_never_vary_leave_no_basis():
    subspace = Subspace(SubspaceConfig(rank=3, batch=4), np.ones(60))
    for _ in range(8):
        subspace.add(np.ones(60))
    assert subspace.basis.shape == (0, 60)


def test_old_variations_are_forgotten(directions):
    subspace = Subspace(SubspaceConfig(rank=1, batch=5, forgetting=0.5), np.zeros(60))
    rng = np.random.default_rng(2)
    for row in directions:
        for value in rng.normal(size=25):
            subspace.add(value * row)
    assert abs(subspace.basis[0] @ directions[1]) > 0.99


@pytest.mark.parametrize(("field", "value"), [("rank", 0), ("batch", 0), ("forgetting", 1.5)])
def test_bad_settings_are_refused(field, value):
    with pytest.raises(ValueError, match=field):
        SubspaceConfig(**{field: value})
