"""Pictures for the hall that a camera flies through: full of corners, and free of the target's hue.

Nothing is as saturated as the target, and nothing has its hue: its colour alone identifies it.
"""

import cv2
import numpy as np

_PAINTS = (
    (46, 52, 60),
    (92, 104, 112),
    (150, 156, 158),
    (214, 212, 204),
    (236, 232, 220),
    (58, 84, 110),
    (96, 128, 148),
    (70, 104, 84),
    (128, 148, 116),
    (168, 160, 124),
)
"""Greys, slate blues, mosses and sand (RGB)."""
_LEVELS = np.array(_PAINTS, float).sum(axis=1) / 3.0
_SHIFT = 4
"""Corners are given in sixteenths of a pixel."""
_LEAST_CONTRAST = 60.0
"""Least difference between a shape and what it stands on, in grey levels."""


def mural(size_px: tuple[int, int], pitch_px: float, rng: np.random.Generator) -> np.ndarray:
    """(h, w, 3) uint8 wall with one angular blob in every cell of a grid.

    Args:
        size_px: Columns and rows.
        pitch_px: Side of a cell; blobs are about half as large.
        rng: Draws places, shapes and paints.
    """
    width, height = size_px
    ground = np.array(_PAINTS[2], float)
    picture = np.empty((height, width, 3), np.uint8)
    picture[:] = ground.astype(np.uint8)
    for top in np.arange(0.0, height, pitch_px):
        for left in np.arange(0.0, width, pitch_px):
            centre = np.array([left, top]) + pitch_px * rng.uniform(0.35, 0.65, 2)
            colour = _contrasting(ground, rng)
            _blob(picture, centre, pitch_px * rng.uniform(0.2, 0.36), colour, rng)
            inner = _contrasting(colour, rng)
            _blob(picture, centre, pitch_px * rng.uniform(0.08, 0.14), inner, rng)
    return _mottled(picture, rng)


def labels(tile_px: int, count: int, rng: np.random.Generator) -> np.ndarray:
    """(n tile, n tile, 3) uint8 of n² = `count` different labels for the faces of crates."""
    side = round(count**0.5)
    if side * side != count:
        raise ValueError(f"count must be a square number, got {count}")
    picture = np.empty((side * tile_px, side * tile_px, 3), np.uint8)
    for row in range(side):
        for column in range(side):
            y, x = row * tile_px, column * tile_px
            picture[y : y + tile_px, x : x + tile_px] = _label(tile_px, rng)
    return picture


def _label(size_px: int, rng: np.random.Generator) -> np.ndarray:
    ground = np.array(_PAINTS[rng.integers(len(_PAINTS))], float)
    tile = np.empty((size_px, size_px, 3), np.uint8)
    tile[:] = ground.astype(np.uint8)
    for quarter in rng.permutation(4)[: rng.integers(2, 5)]:
        corner = 0.5 * size_px * np.array([quarter % 2, quarter // 2])
        centre = corner + size_px * rng.uniform(0.2, 0.3, 2)
        _blob(tile, centre, size_px * rng.uniform(0.1, 0.2), _contrasting(ground, rng), rng)
    return _mottled(tile, rng)


def _contrasting(ground: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """(3,) a paint that stands out from (3,) what it is painted on."""
    paints = np.array(_PAINTS, float)
    far = paints[np.abs(_LEVELS - ground.sum() / 3.0) > _LEAST_CONTRAST]
    return far[rng.integers(len(far))]


def _blob(
    picture: np.ndarray,
    centre_px: np.ndarray,
    radius_px: float,
    colour: np.ndarray,
    rng: np.random.Generator,
) -> None:
    """A polygon of three to six corners, in place."""
    corners = int(rng.integers(3, 7))
    steps = rng.uniform(0.7, 1.3, corners)
    angles = 2.0 * np.pi * (np.cumsum(steps) / steps.sum() + rng.random())
    radii = radius_px * rng.uniform(0.7, 1.3, corners)
    points = centre_px + radii[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    points = np.rint(points * 2**_SHIFT).astype(np.int32)
    cv2.fillPoly(picture, [points], colour.tolist(), cv2.LINE_AA, _SHIFT)


def _mottled(picture: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The picture with the mottle of a real surface."""
    height, width = picture.shape[:2]
    coarse = rng.normal(0.0, 5.0, (-(-height // 8), -(-width // 8)))
    patches = cv2.resize(coarse, (width, height), interpolation=cv2.INTER_LINEAR)
    return np.clip(picture + patches[..., None], 0, 255).astype(np.uint8)
