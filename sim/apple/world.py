"""The compiled orchard: fruit, stem, branch, leaves, light, the UR5 and two cameras.

The world's frame is that of the arm's mounting face: x towards the tree, z up. Nothing moves but
the arm and a camera that floats freely, for places that the arm cannot reach.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import cv2
import mujoco
import numpy as np

from sim import ASSETS
from sim.apple import paint
from sim.apple.fruit import CALYX_DEPTH_M, CALYX_HALF_THICKNESS_M, PlacedFruit
from sim.apple.leaves import Leaf, make_blade
from sim.arm.arms import JOINT_NAMES, UR5
from sim.checks import require_within
from sim.imaging.camera import OffscreenRenderer

WIDTH_PX, HEIGHT_PX = 640, 480
FOVY_RAD = math.radians(45.0)
HAND_CAMERA, FREE_CAMERA, STUDIO = "hand_camera", "free_camera", "studio"
FLANGE_CAMERA_M = (0.0, 0.0, 0.055)
"""The camera's optical centre in the frame of the flange, whose axes are the camera's own."""
FLOOR_Z_M = -0.60
_STUDIO_M = (0.35, -1.45, 0.75), (0.55, 0.0, 0.25)
"""Where the camera for videos stands, and what it looks at."""
_QUICK = [cv2.IMWRITE_PNG_COMPRESSION, 1]
_GEOM = mujoco.mjtGeom


@dataclass(frozen=True)
class Light:
    """One lamp beside the sky's even light."""

    direction: tuple[float, float, float] = (0.5, 0.2, -0.8)
    """Where its rays go, in the world; need not be of unit length."""
    lamp: float = 0.65
    """Brightness of the lamp on a surface that faces it."""
    sky: float = 0.40
    """Brightness of the light from everywhere."""

    def __post_init__(self) -> None:
        require_within(self, 0.0, 2.0, "lamp", "sky")
        if not (np.isfinite(self.direction).all() and np.linalg.norm(self.direction) > 1e-9):
            raise ValueError(f"direction must be a vector other than zero, got {self.direction!r}")


@dataclass(frozen=True, eq=False)
class OrchardConfig:
    """All that is in the world."""

    fruit: PlacedFruit
    others: tuple[PlacedFruit, ...] = ()
    """More fruits."""
    leaves: tuple[Leaf, ...] = ()
    light: Light = Light()
    backdrop_from_m: tuple[float, float, float] = (0.0, 0.0, 0.3)
    """The backdrop stands 2.5 m beyond the fruit, square to the line from here."""


@dataclass(frozen=True, eq=False)
class Masks:
    """What each pixel of an image truly shows (h, w) bool: for oracles and tests."""

    fruit: np.ndarray
    """The fruit itself, its calyx included."""
    calyx: np.ndarray


def intrinsics() -> np.ndarray:
    """(3, 3) matrix K of both cameras; pixel centres lie at integer coordinates."""
    focal_px = 0.5 * HEIGHT_PX / math.tan(0.5 * FOVY_RAD)
    return np.array(
        [[focal_px, 0, (WIDTH_PX - 1) / 2], [0, focal_px, (HEIGHT_PX - 1) / 2], [0, 0, 1.0]]
    )


def look_at(eye_m: np.ndarray, point_m: np.ndarray) -> np.ndarray:
    """(4, 4) T_world_camera at an eye that looks at a point, its image upright."""
    z = np.asarray(point_m, float) - eye_m
    z /= np.linalg.norm(z)
    x = np.cross(z, [0.0, 0.0, 1.0])
    if not np.linalg.norm(x) > 1e-9:
        raise ValueError(f"a camera that looks straight up or down has no upright image: {eye_m}")
    x /= np.linalg.norm(x)
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = np.column_stack([x, np.cross(z, x), z]), eye_m
    return T


class Orchard:
    """One world, ready to be looked at; a context manager that frees its renderer."""

    def __init__(self, config: OrchardConfig, rng: np.random.Generator) -> None:
        """`rng` paints the skin, the leaves and the backdrop."""
        self.config = config
        self.model: Any = _compile(config, rng)
        self.data: Any = mujoco.MjData(self.model)
        self._joints = [int(self.model.joint(name).qposadr[0]) for name in JOINT_NAMES]
        self._renderer: OffscreenRenderer | None = None
        mujoco.mj_forward(self.model, self.data)

    def __enter__(self) -> Orchard:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Frees the OpenGL context; a second call does nothing."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def set_arm(self, q_rad: np.ndarray) -> None:
        """Puts the arm into a configuration (6,), at once."""
        self.data.qpos[self._joints] = q_rad
        self._update()

    def set_free_camera(self, T_world_camera: np.ndarray) -> None:
        """Puts the free camera at a (4, 4) pose with x right, y down, z forward."""
        R = T_world_camera[:3, :3] * [1.0, -1.0, -1.0]
        index = self.model.body(FREE_CAMERA).mocapid[0]
        self.data.mocap_pos[index] = T_world_camera[:3, 3]
        mujoco.mju_mat2Quat(self.data.mocap_quat[index], R.ravel())
        self._update()

    def camera_pose(self, camera: str) -> np.ndarray:
        """(4, 4) true T_world_camera of a camera, x right, y down, z forward."""
        index = self.model.camera(camera).id
        T = np.eye(4)
        T[:3, :3] = self.data.cam_xmat[index].reshape(3, 3) * [1.0, -1.0, -1.0]
        T[:3, 3] = self.data.cam_xpos[index]
        return T

    def render(self, camera: str, *, shadows: bool = False) -> np.ndarray:
        """(h, w, 3) uint8 RGB without noise."""
        return self._ready().render(self.model, self.data, camera, shadows=shadows)[0]

    def masks(self, camera: str) -> Masks:
        """What the camera's pixels truly show, by MuJoCo's segmentation."""
        kinds, indices = self._ready().segment(self.model, self.data, camera)
        is_geom = kinds == int(mujoco.mjtObj.mjOBJ_GEOM)
        skin, calyx = (is_geom & (indices == self.model.geom(n).id) for n in ("skin0", "calyx0"))
        return Masks(fruit=skin | calyx, calyx=calyx)

    def _update(self) -> None:
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)

    def _ready(self) -> OffscreenRenderer:
        if self._renderer is None:
            self._renderer = OffscreenRenderer(self.model, WIDTH_PX, HEIGHT_PX)
        return self._renderer


def _compile(config: OrchardConfig, rng: np.random.Generator) -> mujoco.MjModel:
    spec = mujoco.MjSpec.from_file(str(ASSETS / UR5.xml))
    _set_up(spec, config)
    _add_cameras(spec)
    _add_ground(spec)
    _add_backdrop(spec, config, rng)
    for index, fruit in enumerate([config.fruit, *config.others]):
        _add_fruit(spec, index, fruit, rng)
    _add_branch(spec, config.fruit)
    _add_leaves(spec, config.leaves, rng)
    return spec.compile()


def _set_up(spec: Any, config: OrchardConfig) -> None:
    light = config.light
    spec.stat.extent, spec.stat.center = 2.0, [0.8, 0.0, 0.3]
    spec.visual.map.znear, spec.visual.map.zfar = 0.02, 10.0
    quality = spec.visual.quality
    quality.offsamples, quality.numslices, quality.numstacks = 0, 72, 48
    # Shadows of the fruit and its leaves only, sharp ones: 0.3 m around them.
    quality.shadowsize, spec.visual.map.shadowclip = 1024, 0.15
    spec.visual.global_.offwidth, spec.visual.global_.offheight = WIDTH_PX, HEIGHT_PX
    spec.visual.headlight.ambient = [light.sky] * 3
    spec.visual.headlight.diffuse = spec.visual.headlight.specular = [0.0] * 3
    lamp = spec.worldbody.add_light(name="lamp", type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL)
    lamp.dir = np.array(light.direction) / np.linalg.norm(light.direction)
    lamp.pos = config.fruit.centre_m - np.asarray(lamp.dir)
    lamp.castshadow, lamp.ambient = True, [0.0] * 3
    lamp.diffuse, lamp.specular = [light.lamp] * 3, [0.25 * light.lamp] * 3


def _add_cameras(spec: Any) -> None:
    fovy_deg = math.degrees(FOVY_RAD)
    upside = [0.0, 1.0, 0.0, 0.0]  # half a turn about x: MuJoCo's cameras look along -z, y up
    wrist = spec.body("wrist_3")
    wrist.add_camera(name=HAND_CAMERA, pos=FLANGE_CAMERA_M, quat=upside, fovy=fovy_deg)
    wrist.add_site(name=HAND_CAMERA, pos=FLANGE_CAMERA_M, group=4)
    wrist.add_geom(
        name="camera_housing",
        type=_GEOM.mjGEOM_BOX,
        size=[0.028, 0.022, 0.0215],
        pos=[0.0, 0.0, 0.0225],
        rgba=[0.12, 0.12, 0.13, 1.0],
        contype=8,
        conaffinity=15,
        mass=0.15,
    )
    body = spec.worldbody.add_body(name=FREE_CAMERA, mocap=True)
    body.add_camera(name=FREE_CAMERA, fovy=fovy_deg)
    eye, middle = np.array(_STUDIO_M[0]), np.array(_STUDIO_M[1])
    T = look_at(eye, middle)
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, (T[:3, :3] * [1.0, -1.0, -1.0]).ravel())
    spec.worldbody.add_camera(name=STUDIO, pos=eye, quat=quat, fovy=fovy_deg)


def _add_ground(spec: Any) -> None:
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.58, 0.70, 0.86],
        rgb2=[0.86, 0.89, 0.90],
        width=64,
        height=384,
    )
    floor = dict(pos=[0.0, 0.0, FLOOR_Z_M], size=[8.0, 8.0, 8.0], rgba=[0.46, 0.52, 0.36, 1.0])
    spec.worldbody.add_geom(
        name="floor", type=_GEOM.mjGEOM_PLANE, contype=0, conaffinity=0, **floor
    )
    half_m = 0.5 * (-FLOOR_Z_M)
    spec.worldbody.add_geom(
        name="pedestal",
        type=_GEOM.mjGEOM_CYLINDER,
        size=[0.085, half_m, 0.0],
        pos=[0.0, 0.0, -half_m],
        rgba=[0.36, 0.38, 0.41, 1.0],
        contype=0,
        conaffinity=0,
    )


def _add_backdrop(spec: Any, config: OrchardConfig, rng: np.random.Generator) -> None:
    """A picture beyond the tree; emissive, so that the lamp does not change it."""
    _paint_2d(spec, "backdrop", paint.backdrop(rng), emission=0.2)
    away = config.fruit.centre_m - np.array(config.backdrop_from_m)
    away = np.array([away[0], away[1], 0.0]) / np.linalg.norm(away[:2])
    right = np.cross(away, [0.0, 0.0, 1.0])
    R = np.column_stack([right, [0.0, 0.0, 1.0], np.cross(right, [0.0, 0.0, 1.0])])
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, R.ravel())
    spec.worldbody.add_geom(
        name="backdrop",
        type=_GEOM.mjGEOM_PLANE,
        size=[4.0, 3.0, 1.0],
        pos=config.fruit.centre_m + 2.5 * away,
        quat=quat,
        material="backdrop",
        contype=0,
        conaffinity=0,
    )


def _add_fruit(spec: Any, index: int, placed: PlacedFruit, rng: np.random.Generator) -> None:
    fruit = placed.fruit
    faces = paint.apple_skin(rng)
    files = [f"skin{index}_{face}.png" for face in paint.FACES]
    _keep(spec, dict(zip(files, faces, strict=True)))
    texture = spec.add_texture(name=f"skin{index}", type=mujoco.mjtTexture.mjTEXTURE_CUBE)
    texture.cubefiles = files
    _add_material(spec, f"skin{index}", specular=0.25, shininess=0.35)
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, np.ascontiguousarray(placed.rotation).ravel())
    body = spec.worldbody.add_body(name=f"fruit{index}", pos=placed.centre_m, quat=quat)
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
        contype=0,
        conaffinity=0,
    )
    top_m = half_m + fruit.stem_length_m
    _add_rod(body, f"stem{index}", (0, 0, half_m - 0.004), (0, 0, top_m), fruit.stem_radius_m)


def _add_branch(spec: Any, placed: PlacedFruit) -> None:
    """From the stem's end up to a twig that crosses above, beyond the fruit."""
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
        contype=0,
        conaffinity=0,
    )


def _add_leaves(spec: Any, leaves: tuple[Leaf, ...], rng: np.random.Generator) -> None:
    if not leaves:
        return
    _paint_2d(spec, "leaf", paint.leaf_picture(rng), emission=0.0)
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
        quat = np.empty(4)
        mujoco.mju_mat2Quat(quat, np.ascontiguousarray(leaf.rotation).ravel())
        spec.worldbody.add_geom(
            name=f"leaf{index}",
            type=_GEOM.mjGEOM_MESH,
            meshname=f"leaf{index}",
            pos=leaf.centre_m,
            quat=quat,
            material="leaf",
            rgba=[leaf.shade, leaf.shade, leaf.shade, 1.0],
            contype=0,
            conaffinity=0,
        )


def _paint_2d(spec: Any, name: str, picture: np.ndarray, emission: float) -> None:
    _keep(spec, {f"{name}.png": picture})
    spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, file=f"{name}.png")
    _add_material(spec, name, specular=0.05, shininess=0.1).emission = emission


def _add_material(spec: Any, name: str, specular: float, shininess: float) -> Any:
    material = spec.add_material(name=name, specular=specular, shininess=shininess)
    textures = list(material.textures)
    textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
    material.textures = textures
    return material


def _keep(spec: Any, pictures: dict[str, np.ndarray]) -> None:
    """Hands the pictures to the compiler as files in memory."""
    encoded = {
        file: cv2.imencode(".png", picture[..., ::-1], _QUICK)[1].tobytes()
        for file, picture in pictures.items()
    }
    spec.assets = dict(spec.assets) | encoded
