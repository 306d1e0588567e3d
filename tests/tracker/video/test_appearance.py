import numpy as np
import pytest
import videos

from tracker.box_tracker import warp_of_box
from tracker.video.appearance import Appearance, AppearanceConfig, Subspace, SubspaceConfig
from tracker.video.window import cut_window

BOX = np.array([60.0, 50.0, *videos.SIZE_PX])
WARP = warp_of_box(BOX)
UNIT_PX = float(np.sqrt(BOX[2] * BOX[3]))


def window_of(image):
    return cut_window(image, WARP[:2, 2], UNIT_PX, 2.5, 32)


def seen(look, image):
    window = window_of(image)
    return look.fit(look.layers(window), window.to_window @ WARP)


def look_at(image, blur=0.06, **changes):
    config = AppearanceConfig(blurs=(blur,), **changes)
    return Appearance(config, blur, window_of(image), BOX)


@pytest.fixture(scope="module")
def views():
    """The same place with three different targets in it."""
    return [videos.film([WARP], seed=seed)[0] for seed in range(3)]


def test_the_first_picture_fits_itself(views):
    assert seen(look_at(views[0]), views[0]).ncc > 0.999


def test_a_template_follows_what_it_learns_and_an_anchor_holds_it(views):
    for anchor, followed in ((0.0, 0.95), (1.0, None)):
        look = look_at(views[0], update_rate=0.5, update_ncc=0.0, anchor=anchor)
        before = seen(look, views[1])
        for _ in range(8):
            look.learn(seen(look, views[1]))
        after = seen(look, views[1]).ncc
        assert after == before.ncc if followed is None else after > followed


def test_a_poor_match_teaches_nothing(views):
    look = look_at(views[0], update_ncc=0.99)
    template = look.matcher.template
    look.learn(seen(look, views[1]))
    assert look.matcher.template is template


def test_a_learnt_variation_costs_less_than_before(views):
    """Two views in turn: the basis then spans what lies between them."""
    costs = {}
    for subspace in (None, SubspaceConfig(rank=2, batch=2)):
        look = look_at(views[0], update_ncc=0.0, subspace=subspace)
        for k in range(8):
            look.learn(seen(look, views[k % 2]))
        window = window_of(views[1])
        fit = look.matcher.fit(look.layers(window), (window.to_window @ WARP)[None], 9.0)
        costs[subspace is None] = fit.cost[0]
    assert costs[False] < 0.2 * costs[True]


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("grid", 3),
        ("blurs", ()),
        ("blurs", (0.0,)),
        ("blurs", (0.05, 0.1)),
        ("update_rate", 1.5),
        ("anchor", -0.1),
        ("update_ncc", 2.0),
    ],
)
def test_bad_settings_are_refused(field, value):
    with pytest.raises(ValueError, match=field):
        AppearanceConfig(**{field: value})


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
def test_bad_settings_of_a_subspace_are_refused(field, value):
    with pytest.raises(ValueError, match=field):
        SubspaceConfig(**{field: value})
