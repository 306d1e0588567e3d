"""The compiled orchard: fruit, stem, branch, leaves, light, the UR5 and two cameras.

The world's frame is that of the arm's mounting face: x towards the tree, z up. Nothing moves but
the arm and a camera that floats freely, for places that the arm cannot reach.
"""

import math
from dataclasses import dataclass
from typing import Any, Self

import mujoco
import numpy as np

from sim import ASSETS, geometry
from sim.apple.fruit import PlacedFruit
from sim.apple.leaves import Leaf
from sim.apple.tree import DULL, add_branch, add_fruit, add_leaves, backdrop
from sim.arm.embodiments import JOINT_NAMES, UR5
from sim.checks import require_within
from sim.geometry import MUJOCO_AXES, MUJOCO_QUAT, quaternion, transform
from sim.imaging.camera import OffscreenRenderer
from sim.imaging.spec import UNTOUCHABLE, add_light, add_picture, set_mocap, set_up, update_poses

WIDTH_PX, HEIGHT_PX = 640, 480
FOVY_RAD = math.radians(45.0)
HAND_CAMERA, FREE_CAMERA, STUDIO = "hand_camera", "free_camera", "studio"
FLANGE_CAMERA_M = (0.0, 0.0, 0.055)
"""The camera's optical centre in the frame of the flange, whose axes are the camera's own."""
FLOOR_Z_M = -0.60
_STUDIO_M = (0.35, -1.45, 0.75), (0.55, 0.0, 0.25)
"""Where the camera for videos stands, and what it looks at."""
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
    return geometry.intrinsics(WIDTH_PX, HEIGHT_PX, FOVY_RAD)


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

    def __enter__(self) -> Self:
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
        update_poses(self.model, self.data)

    def set_free_camera(self, T_world_camera: np.ndarray) -> None:
        """Puts the free camera at a (4, 4) pose with x right, y down, z forward."""
        R = T_world_camera[:3, :3] * MUJOCO_AXES
        set_mocap(self.model, self.data, FREE_CAMERA, T_world_camera[:3, 3], R)
        update_poses(self.model, self.data)

    def camera_pose(self, camera: str) -> np.ndarray:
        """(4, 4) true T_world_camera of a camera, x right, y down, z forward."""
        index = self.model.camera(camera).id
        R = self.data.cam_xmat[index].reshape(3, 3) * MUJOCO_AXES
        return transform(R, self.data.cam_xpos[index])

    def render(self, camera: str, *, shadows: bool = False) -> np.ndarray:
        """(h, w, 3) uint8 RGB without noise."""
        return self._ready().render(self.model, self.data, camera, shadows=shadows)[0]

    def masks(self, camera: str) -> Masks:
        """What the camera's pixels truly show, by MuJoCo's segmentation."""
        kinds, indices = self._ready().segment(self.model, self.data, camera)
        is_geom = kinds == int(mujoco.mjtObj.mjOBJ_GEOM)
        skin, calyx = (is_geom & (indices == self.model.geom(n).id) for n in ("skin0", "calyx0"))
        return Masks(fruit=skin | calyx, calyx=calyx)

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
        add_fruit(spec, index, fruit, rng)
    add_branch(spec, config.fruit)
    add_leaves(spec, config.leaves, rng)
    return spec.compile()


def _set_up(spec: Any, config: OrchardConfig) -> None:
    light = config.light
    set_up(spec, clip_m=(0.02, 10.0), ambient=light.sky, extent_m=2.0)
    spec.stat.center = [0.8, 0.0, 0.3]
    quality = spec.visual.quality
    quality.numslices, quality.numstacks = 72, 48
    # Shadows of the fruit and its leaves only, sharp ones: 0.3 m around them.
    quality.shadowsize, spec.visual.map.shadowclip = 1024, 0.15
    spec.visual.global_.offwidth, spec.visual.global_.offheight = WIDTH_PX, HEIGHT_PX
    lamp = add_light(spec, "lamp", light.lamp, specular=[0.25 * light.lamp] * 3, castshadow=True)
    lamp.dir = np.array(light.direction) / np.linalg.norm(light.direction)
    lamp.pos = config.fruit.centre_m - np.asarray(lamp.dir)


def _add_cameras(spec: Any) -> None:
    fovy_deg = math.degrees(FOVY_RAD)
    wrist = spec.body("wrist_3")
    wrist.add_camera(name=HAND_CAMERA, pos=FLANGE_CAMERA_M, quat=MUJOCO_QUAT, fovy=fovy_deg)
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
    quat = quaternion(geometry.look_at(*_STUDIO_M)[:3, :3] * MUJOCO_AXES)
    spec.worldbody.add_camera(name=STUDIO, pos=_STUDIO_M[0], quat=quat, fovy=fovy_deg)


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
    spec.worldbody.add_geom(name="floor", type=_GEOM.mjGEOM_PLANE, **UNTOUCHABLE, **floor)
    half_m = 0.5 * (-FLOOR_Z_M)
    spec.worldbody.add_geom(
        name="pedestal",
        type=_GEOM.mjGEOM_CYLINDER,
        size=[0.085, half_m, 0.0],
        pos=[0.0, 0.0, -half_m],
        rgba=[0.36, 0.38, 0.41, 1.0],
        **UNTOUCHABLE,
    )


def _add_backdrop(spec: Any, config: OrchardConfig, rng: np.random.Generator) -> None:
    """A picture beyond the tree; emissive, so that the lamp does not change it."""
    add_picture(spec, "backdrop", backdrop(rng), *DULL).emission = 0.2
    away = config.fruit.centre_m - np.array(config.backdrop_from_m)
    away = np.array([away[0], away[1], 0.0]) / np.linalg.norm(away[:2])
    right = np.cross(away, [0.0, 0.0, 1.0])
    R = np.column_stack([right, [0.0, 0.0, 1.0], np.cross(right, [0.0, 0.0, 1.0])])
    spec.worldbody.add_geom(
        name="backdrop",
        type=_GEOM.mjGEOM_PLANE,
        size=[4.0, 3.0, 1.0],
        pos=config.fruit.centre_m + 2.5 * away,
        quat=quaternion(R),
        material="backdrop",
        **UNTOUCHABLE,
    )
