"""What grows in the orchard, painted in memory and added to its MjSpec: fruits, branch, leaves."""

from functools import cache
from typing import Any

import cv2
import mujoco
import numpy as np

from sim.apple.fruit import CALYX_DEPTH_M, CALYX_HALF_THICKNESS_M, PlacedFruit
from sim.apple.leaves import Leaf, make_blade
from sim.geometry import quaternion
from sim.imaging.spec import UNTOUCHABLE, add_files, add_material, add_picture

DULL = 0.05, 0.1
"""Specular and shininess of what hardly shines."""
_GEOM = mujoco.mjtGeom

FACES = ("right", "left", "up", "down", "front", "back")
"""Faces of a cube texture in MuJoCo's order: +x, -x, +y, -y, +z, -z."""

_RED = np.array([172.0, 26.0, 32.0])
_BLUSH = np.array([206.0, 74.0, 40.0])
_PALE = np.array([224.0, 150.0, 70.0])


def add_fruit(spec: Any, index: int, placed: PlacedFruit, rng: np.random.Generator) -> None:
    """Adds the fruit of that number with its calyx and stem; `rng` paints its skin."""
    fruit = placed.fruit
    faces = apple_skin(rng)
    files = [f"skin{index}_{face}.png" for face in FACES]
    add_files(spec, dict(zip(files, faces, strict=True)))
    texture = spec.add_texture(name=f"skin{index}", type=mujoco.mjtTexture.mjTEXTURE_CUBE)
    texture.cubefiles = files
    add_material(spec, f"skin{index}", specular=0.25, shininess=0.35)
    body = spec.worldbody.add_body(
        name=f"fruit{index}", pos=placed.centre_m, quat=quaternion(placed.rotation)
    )
    half_m = fruit.half_height_m
    body.add_geom(
        name=f"skin{index}",
        type=_GEOM.mjGEOM_ELLIPSOID,
        size=[fruit.radius_m, fruit.radius_m, half_m],
        material=f"skin{index}",
        contype=1,
        conaffinity=14,
    )
    radius_m = fruit.calyx_radius_m
    body.add_geom(
        name=f"calyx{index}",
        type=_GEOM.mjGEOM_ELLIPSOID,
        size=[radius_m, radius_m, CALYX_HALF_THICKNESS_M],
        pos=[0.0, 0.0, -half_m + CALYX_DEPTH_M],
        rgba=[0.27, 0.18, 0.10, 1.0],
        **UNTOUCHABLE,
    )
    top_m = half_m + fruit.stem_length_m
    _add_rod(body, f"stem{index}", (0, 0, half_m - 0.004), (0, 0, top_m), fruit.stem_radius_m)


def add_branch(spec: Any, placed: PlacedFruit) -> None:
    """Adds a twig from the end of the fruit's stem to a branch that crosses above, beyond it."""
    fruit = placed.fruit
    end = placed.centre_m + placed.axis * (fruit.half_height_m + fruit.stem_length_m)
    above = end + np.array([0.05, 0.0, 0.10])
    _add_rod(spec.worldbody, "twig", end, above, 0.003)
    along = np.array([0.0, 0.5, 0.03])
    _add_rod(spec.worldbody, "branch", above - along, above + along, 0.008)


def _add_rod(body: Any, name: str, start_m: Any, end_m: Any, radius_m: float) -> None:
    body.add_geom(
        name=name,
        type=_GEOM.mjGEOM_CAPSULE,
        fromto=[*start_m, *end_m],
        size=[radius_m, 0.0, 0.0],
        rgba=[0.36, 0.26, 0.17, 1.0],
        **UNTOUCHABLE,
    )


def add_leaves(spec: Any, leaves: tuple[Leaf, ...], rng: np.random.Generator) -> None:
    """Adds the leaves; `rng` paints their picture and draws how each is curled and folded."""
    if not leaves:
        return
    add_picture(spec, "leaf", leaf_picture(rng), *DULL)
    for index, leaf in enumerate(leaves):
        blade = make_blade(curl=rng.uniform(0.02, 0.14), fold=rng.uniform(0.05, 0.25))
        size = np.array([leaf.length_m, leaf.width_m, leaf.length_m])
        spec.add_mesh(
            name=f"leaf{index}",
            uservert=(blade.vertices * size).ravel().tolist(),
            userface=blade.triangles.ravel().tolist(),
            usertexcoord=blade.texture.ravel().tolist(),
            userfacetexcoord=blade.triangles.ravel().tolist(),
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
        )
        spec.worldbody.add_geom(
            name=f"leaf{index}",
            type=_GEOM.mjGEOM_MESH,
            meshname=f"leaf{index}",
            pos=leaf.centre_m,
            quat=quaternion(leaf.rotation),
            material="leaf",
            rgba=[leaf.shade, leaf.shade, leaf.shade, 1.0],
            **UNTOUCHABLE,
        )


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
