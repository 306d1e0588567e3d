"""Leaves: closed meshes, and where they hang."""

import numpy as np

from sim.apple.fruit import PlacedFruit
from sim.apple.leaves import leaves_behind, leaves_in_front, make_blade
from sim.apple.world import FREE_CAMERA, intrinsics


def shares(make, in_front, seed):
    """Visible share of the fruit over the approach's arc."""
    fruit: PlacedFruit = make["placed"]()
    found = []
    with make["orchard"](fruit, behind=12, in_front=in_front, seed=seed) as orchard:
        for turn in np.radians([-25.0, 0.0, 25.0]):
            T = make["view"](0.4, turn)
            orchard.set_free_camera(T)
            x, y = fruit.outline_px(intrinsics(), T, 300).T
            area = 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
            found.append(orchard.masks(FREE_CAMERA).fruit.sum() / area)
    return np.array(found)


def test_a_blade_is_a_closed_surface():
    blade = make_blade()
    edges = np.sort(blade.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    _, counts = np.unique(edges, axis=0, return_counts=True)
    assert (counts == 2).all()
    assert np.ptp(blade.vertices[:, 0]) == 1.0
    assert 0.8 < np.ptp(blade.vertices[:, 1]) <= 1.0
    assert ((blade.texture >= 0.0) & (blade.texture <= 1.0)).all()


def test_leaves_behind_hide_nothing_along_the_approach(make):
    for seed in range(3):
        assert shares(make, 0, seed).min() > 0.98


def test_leaves_in_front_hide_a_part_and_not_all(make):
    seen = np.array([shares(make, 3, seed) for seed in range(3)])
    assert 0.2 < np.median(seen) < 0.9


def test_leaves_are_on_their_side_of_the_fruit(make):
    rng, centre, frame = np.random.default_rng(1), np.array([1.0, 0.0, 0.3]), make["view"]()[:3, :3]
    forward = frame[:, 2]
    behind = leaves_behind(rng, centre, frame, 20)
    front = leaves_in_front(rng, centre, frame, 0.04, 20)
    assert min((leaf.centre_m - centre) @ forward for leaf in behind) > 0.04
    assert max((leaf.centre_m - centre) @ forward for leaf in front) < -0.04
    for leaf in [*behind, *front]:
        assert np.allclose(leaf.rotation.T @ leaf.rotation, np.eye(3))
        assert np.linalg.det(leaf.rotation) > 0.0
