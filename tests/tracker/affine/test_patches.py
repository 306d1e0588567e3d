from dataclasses import replace

import numpy as np

from tracker.affine import aff2
from tracker.affine.patches import Layers, PatchMatcher


def normalised(values):
    return (values - values.mean()) / values.std()


def test_patch_of_a_linear_ramp_is_exact(template):
    column, row = np.meshgrid(np.arange(120.0), np.arange(90.0))
    layers = Layers.of(2 * column + row)
    for warp in (aff2.similarity(20.0, 0.3, [60, 40]), aff2.similarity(15.0, 2.0, [50, 50])):
        patch, visible = PatchMatcher(template).patch(layers, warp)
        q = warp @ template.points
        np.testing.assert_allclose(patch, normalised(2 * q[0] + q[1]), atol=1e-4)
        np.testing.assert_array_equal(visible, 1.0)


def test_the_outermost_pixels_are_read_and_nothing_beyond(template):
    """A warp whose outermost samples lie on the image's border, and one a little larger."""
    w, h = np.abs(template.points[:2]).max(axis=1)
    layers = Layers.of(np.random.default_rng(0).random((9, 13)))
    whole = np.array([[6.0 / w, 0, 6.0], [0, 4.0 / h, 4.0], [0, 0, 1]])
    matcher = PatchMatcher(template)
    almost = whole @ np.diag([1 - 1e-6, 1 - 1e-6, 1])
    assert matcher.patch(layers, almost)[1].all()
    too_large = matcher.patch(layers, whole @ np.diag([1.001, 1.001, 1]))[1]
    rows, columns = template.shape
    assert too_large.sum() == (rows - 2) * (columns - 2)


def test_what_the_mask_hides_does_not_count(template):
    image = np.random.default_rng(0).random((60, 80)) * 255
    visibility = np.ones((60, 80))
    visibility[:, 40:] = 0
    warp = aff2.similarity(25.0, 0.0, [39.5, 30])
    matcher = PatchMatcher(template)
    _, visible = matcher.patch(Layers.of(image, visibility), warp)
    q = warp @ template.points
    np.testing.assert_array_equal(visible, q[0] < 39)
    other = np.where(visibility > 0, image, 17.0)
    fits = [matcher.fit(Layers.of(i, visibility), warp[None], 9.0) for i in (image, other)]
    np.testing.assert_array_equal(fits[0].ncc, fits[1].ncc)
    np.testing.assert_array_equal(fits[0].cost, fits[1].cost)


def test_far_away_and_broken_warps_show_nothing(template, monkeypatch):
    """Also where memory that nobody has written yet holds no numbers."""
    monkeypatch.setattr(np, "empty", lambda shape, dtype=float: np.full(shape, np.nan, dtype))
    layers = Layers.of(np.ones((50, 60)))
    far = aff2.similarity(10.0, 0.0, [1e9, 0.0])
    fit = PatchMatcher(template).fit(layers, np.stack([far, np.full((3, 3), np.nan)]), 1.0)
    np.testing.assert_array_equal(fit.visible_fraction, 0.0)
    np.testing.assert_array_equal(fit.ncc, 0.0)
    np.testing.assert_array_equal(fit.cost, 0.0)


def test_information_of_a_part_joins_that_of_the_whole(template):
    """Hiding one pixel in a corner changes the information little: both ways of summing agree."""
    image = np.random.default_rng(0).random((60, 80)) * 255
    warps = aff2.similarity(25.0, 0.2, [40, 30])[None]
    visibility = np.ones((60, 80))
    matcher = PatchMatcher(template)
    whole = matcher.linearise(Layers.of(image, visibility), warps, 9.0)
    inside = np.round((warps[0] @ template.points)[:2, 0]).astype(int)
    visibility[inside[1], inside[0]] = 0
    part = matcher.linearise(Layers.of(image, visibility), warps, 9.0)
    assert 0.9 < part[2][0, 0] < 1.0
    np.testing.assert_allclose(part[1], whole[1], atol=0.1 * np.abs(whole[1]).max())


def test_what_the_basis_explains_gives_neither_gradient_nor_information(template):
    """A step of Gauss-Newton from there is none: motion is what the basis takes away."""
    shift = np.asarray(template.jacobian[:, 4], float)
    shift -= shift.mean()
    shift -= (shift @ template.values / len(shift)) * template.values
    shift /= np.linalg.norm(shift)
    with_basis = replace(template, basis=shift[None].astype(np.float32))
    image = np.random.default_rng(0).random((60, 80)) * 255
    warps = aff2.similarity(25.0, 0.0, [40, 30])[None]
    plain, other = (
        PatchMatcher(t).linearise(Layers.of(image), warps, 9.0) for t in (template, with_basis)
    )
    assert abs(other[0][0, 4]) < 1e-3 * abs(plain[0][0, 4])
    assert other[1][0, 4, 4] < 1e-6 * plain[1][0, 4, 4]


def test_a_patch_is_the_same_wherever_the_image_ends(template):
    """Patches near the rim and patches far from it are sampled by different code."""
    image = np.random.default_rng(0).random((60, 80)) * 255
    w, h = np.abs(template.points[:2]).max(axis=1)
    warp = np.array([[20.0 / w, 0, 40.0], [0, 10.0 / h, 30.0], [0, 0, 1]])
    matcher = PatchMatcher(template)
    whole = matcher.patch(Layers.of(image), warp)
    moved = warp.copy()
    moved[:2, 2] -= (20.0, 20.0)
    cut = matcher.patch(Layers.of(image[20:41, 20:61]), moved)
    for a, b in zip(whole, cut, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-5)
