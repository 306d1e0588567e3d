"""Pictures of the orchard."""

import numpy as np
import pytest

from sim.apple import tree


@pytest.mark.parametrize(
    ("painted", "shape"),
    [
        (lambda rng: tree.apple_skin(rng, 24), (6, 24, 24, 3)),
        (tree.leaf_picture, (64, 64, 3)),
        (lambda rng: tree.backdrop(rng, 64, 48), (48, 64, 3)),
    ],
)
def test_the_same_generator_paints_the_same_picture(painted, shape):
    pictures = [painted(np.random.default_rng(seed)) for seed in (3, 3, 4)]
    assert pictures[0].shape == shape and pictures[0].dtype == np.uint8
    assert np.array_equal(pictures[0], pictures[1])
    assert not np.array_equal(pictures[0], pictures[2])


def test_faces_of_the_cube_meet_at_their_edges():
    """The last row of one face and the first of its neighbour look almost the same way."""
    n = tree.face_directions(64)
    faces = dict(zip(tree.FACES, n, strict=True))
    assert faces["right"][:, 0] @ faces["front"][:, -1].T == pytest.approx(
        faces["right"][:, 0] @ faces["right"][:, 0].T, abs=0.05
    )
    for face, axis in zip(tree.FACES, [0, 0, 1, 1, 2, 2], strict=True):
        assert (np.abs(faces[face]).argmax(axis=-1) == axis).mean() > 0.95
        sign = 1.0 if face in ("right", "up", "front") else -1.0
        assert (sign * faces[face][..., axis] > 0.5).all()


def test_skin_is_red_all_over():
    skin = tree.apple_skin(np.random.default_rng(0), 32).astype(float)
    assert (skin[..., 0] > 1.5 * np.maximum(skin[..., 1], skin[..., 2])).mean() > 0.97
