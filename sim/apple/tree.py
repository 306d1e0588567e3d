"""What grows in the orchard, added to its MjSpec: fruits with their stems, the branch, leaves."""

from typing import Any

import mujoco
import numpy as np

from sim.apple import paint
from sim.apple.fruit import CALYX_DEPTH_M, CALYX_HALF_THICKNESS_M, PlacedFruit
from sim.apple.leaves import Leaf, make_blade
from sim.geometry import quaternion
from sim.imaging.spec import UNTOUCHABLE, add_files, add_material, add_picture

DULL = 0.05, 0.1
"""Specular and shininess of what hardly shines."""
_GEOM = mujoco.mjtGeom


def add_fruit(spec: Any, index: int, placed: PlacedFruit, rng: np.random.Generator) -> None:
    """Adds the fruit of that number with its calyx and stem; `rng` paints its skin."""
    fruit = placed.fruit
    faces = paint.apple_skin(rng)
    files = [f"skin{index}_{face}.png" for face in paint.FACES]
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
    add_picture(spec, "leaf", paint.leaf_picture(rng), *DULL)
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
