"""Pictures of the orchard, painted in memory from a random generator: skin, leaf and backdrop."""

from functools import cache

import cv2
import numpy as np

FACES = ("right", "left", "up", "down", "front", "back")
"""Faces of a cube texture in MuJoCo's order: +x, -x, +y, -y, +z, -z."""

_RED = np.array([172.0, 26.0, 32.0])
_BLUSH = np.array([206.0, 74.0, 40.0])
_PALE = np.array([224.0, 150.0, 70.0])


@cache
def face_directions(size_px: int) -> np.ndarray:
    """(6, size, size, 3) unit vectors that the pixels of a cube texture lie on (OpenGL's order)."""
    c, r = np.meshgrid(*[(np.arange(size_px) + 0.5) * 2.0 / size_px - 1.0] * 2)
    one = np.ones_like(c)
    faces = ((one, -r, -c), (-one, -r, c), (c, one, r), (c, -one, -r), (c, -r, one), (-c, -r, -one))
    directions = np.stack([np.stack(face, axis=-1) for face in faces])
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    directions.setflags(write=False)
    return directions


def apple_skin(rng: np.random.Generator, size_px: int = 96) -> np.ndarray:
    """(6, size, size, 3) uint8 faces of an apple's skin; z of the fruit is the stem.

    Red with streaks along the meridians, a cheek that the sun has not reached, and lenticels.
    """
    n = face_directions(size_px)
    longitude = np.arctan2(n[..., 1], n[..., 0])
    streaks = np.zeros(longitude.shape)
    for frequency in rng.integers(9, 40, 7):
        wobble = 0.4 * _ripple(n, rng, 3.0)
        streaks += np.cos(frequency * longitude + rng.uniform(0, 2 * np.pi) + wobble)
    streaks = np.clip(0.5 + streaks / 7.0, 0.0, 1.0)
    cheek = np.clip(0.4 + 0.6 * _ripple(n, rng, 1.3), 0.0, 1.0)
    near_stem = np.clip((n[..., 2] - 0.80) / 0.2, 0.0, 1.0)
    share = np.clip(0.15 + 0.45 * cheek * streaks + 0.25 * near_stem, 0.0, 1.0)[..., None]
    skin = (1.0 - share) * _RED + share * _BLUSH
    dots = _lenticels(n, rng, 220)[..., None]
    skin = (1.0 - 0.55 * dots) * skin + 0.55 * dots * _PALE
    return np.clip(np.rint(skin), 0, 255).astype(np.uint8)


def leaf_picture(rng: np.random.Generator, size_px: int = 64) -> np.ndarray:
    """(size, size, 3) uint8 upper side of a leaf: midrib along the rows' middle, side veins."""
    y, x = np.mgrid[0:size_px, 0:size_px] / (size_px - 1.0)
    across = 2.0 * np.abs(y - 0.5)
    phase = 9.0 * (x - 0.55 * across) + rng.uniform(0, 1)
    veins = np.exp(-(((phase % 1.0) - 0.5) ** 2) / 0.004) * (1.0 - across)
    midrib = np.exp(-((across / 0.05) ** 2))
    noise = rng.standard_normal((size_px, size_px))
    mottle = np.asarray(cv2.GaussianBlur(noise, (0, 0), 4.0)) * 60.0
    green = np.array([70.0, 128.0, 44.0]) + mottle[..., None] * [0.5, 1.0, 0.4]
    light = np.clip(0.35 * veins + 0.8 * midrib, 0.0, 1.0)[..., None]
    picture = (1.0 - light) * green + light * np.array([140.0, 178.0, 92.0])
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


def backdrop(rng: np.random.Generator, width_px: int = 512, height_px: int = 384) -> np.ndarray:
    """(h, w, 3) uint8 view out of focus: sky above, rows of trees in haze, grass below."""
    y = np.linspace(0.0, 1.0, height_px)[:, None, None]
    sky = (1.0 - y) * np.array([150.0, 184.0, 222.0]) + y * np.array([222.0, 230.0, 232.0])
    picture = np.broadcast_to(sky, (height_px, width_px, 3)).copy()
    colours = ((168.0, 190.0, 176.0), (132.0, 164.0, 138.0), (98.0, 134.0, 96.0))
    for layer, colour in enumerate(colours):
        top = 0.38 + 0.16 * layer
        for _ in range(46):
            centre = int(rng.uniform(0, width_px)), int((top + rng.uniform(-0.06, 0.3)) * height_px)
            radius = int(rng.uniform(0.04, 0.09) * height_px)
            shade = rng.uniform(0.9, 1.1)
            cv2.circle(picture, centre, radius, tuple(shade * c for c in colour), -1, cv2.LINE_AA)
    grass = y > 0.90
    picture = np.where(grass, np.array([112.0, 138.0, 84.0]), picture)
    picture = cv2.GaussianBlur(picture, (0, 0), 9.0)
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


def _ripple(n: np.ndarray, rng: np.random.Generator, scale: float) -> np.ndarray:
    """A smooth random function of the direction, about -1 to 1."""
    total = np.zeros(n.shape[:-1])
    for wave in rng.standard_normal((6, 3)) * scale:
        total += np.cos(n @ wave * 1.6 + rng.uniform(0, 2 * np.pi))
    return total / 3.0


def _lenticels(n: np.ndarray, rng: np.random.Generator, count: int) -> np.ndarray:
    """1 in the middle of each of the pale dots, falling to 0 at its edge."""
    places = rng.standard_normal((count, 3))
    places /= np.linalg.norm(places, axis=1, keepdims=True)
    cosine = (n.reshape(-1, 3).astype(np.float32) @ places.astype(np.float32).T).max(axis=1)
    radius = np.arccos(np.clip(cosine, -1.0, 1.0)).reshape(n.shape[:-1])
    return np.clip(1.6 - radius / 0.018, 0.0, 1.0)
