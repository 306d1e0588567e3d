"""The hall of the bearing-only experiments in MuJoCo, and the noisy images of its flying camera.

Frames: the world is x, y, z with z up and its origin in the middle of the hall. The robot's body
axes are x forward, y left, z up; its camera looks along x with the axes x right, y down, z forward.
Source of hall, intrinsics and image: [Wu2022] section 6.1.1 and Table 1; what the walls look like
and how large the target is, it does not say.
"""

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from sim.bearing_only.pictures import labels, mural
from sim.checks import require, require_at_least, require_positive
from sim.geometry import MUJOCO_QUAT, R_BODY_CAMERA, fovy_deg
from sim.imaging.camera import OffscreenRenderer
from sim.imaging.degradations import Condition
from sim.imaging.sensor import SensorNoise
from sim.imaging.spec import UNTOUCHABLE, add_light, add_material, set_mocap, set_up, update_poses

WIDTH_PX, HEIGHT_PX = 640, 480
FOCAL_PX = 320.0
"""s_u and s_v."""
CENTRE_PX = (320.0, 240.0)
"""u_0 and v_0, from the image's upper left edge: the middle of the first pixel is (0.5, 0.5)."""
CAMERA = "flyer"
TARGET = "target"

_TILE_PX, _TILES = 64, 64
_REFERENCE_PX = 40
"""Radius of the target in its reference photograph."""


@dataclass(frozen=True)
class HallConfig:
    """What is in the hall, and the noise of the camera."""

    hall_m: tuple[float, float, float] = (25.0, 25.0, 10.0)
    """Half the hall's extent."""
    clear_m: tuple[float, float, float] = (20.0, 20.0, 5.0)
    """Half the extent of the part where the flight takes place; no crate is in it."""
    clear_height_m: float = 1.0
    """Height of the middle of that part."""
    crate_count: int = 120
    crate_m: tuple[float, float] = (0.8, 1.8)
    """Least and greatest edge of a crate."""
    blob_pitch_m: float = 2.0
    """There is one blob on so many metres of wall, in both directions."""
    wall_px_per_m: float = 24.0
    target_radius_m: float = 0.5
    target_rgb: tuple[float, float, float] = (0.86, 0.10, 0.42)
    noise_std: float = 2.0
    """Standard deviation of each pixel and colour, in grey levels of 255."""

    def __post_init__(self) -> None:
        require(self, "positive numbers", _are_positive, ["hall_m", "clear_m"])
        require_positive(self, "blob_pitch_m", "wall_px_per_m", "target_radius_m")
        require_at_least(self, 0, "crate_count", "noise_std")
        if not 0.0 < self.crate_m[0] <= self.crate_m[1]:
            raise ValueError(f"crate_m must be two positive edges in order, got {self.crate_m}")
        room = np.subtract(self.hall_m, self.clear_m) - abs(self.clear_height_m) * np.array(
            [0, 0, 1]
        )
        if self.crate_count and room.max() < 2.0 * self.crate_m[1]:
            raise ValueError(
                f"clear_m {self.clear_m} leaves no room for crates in a hall of {self.hall_m}"
            )


def _are_positive(values: tuple[float, ...]) -> bool:
    return all(math.isfinite(v) and v > 0.0 for v in values)


class HallCamera:
    """Takes the images of one run; close it when done, as it holds an OpenGL context.

    Args:
        config: Hall and sensor.
        scene_rng: Draws the pictures and where the crates hang.
        noise_rng: Draws the noise, which does not depend on what is seen.
    """

    def __init__(
        self,
        config: HallConfig,
        scene_rng: np.random.Generator,
        noise_rng: np.random.Generator,
    ) -> None:
        self.config = config
        self.crates_m = hang_crates(config, scene_rng)
        """(n, 4): centres, and half the edges."""
        self.model = _compile(config, self.crates_m, scene_rng)
        self.data = mujoco.MjData(self.model)
        condition = Condition(colour_noise_std=config.noise_std, depth_noise_std_m=0.0)
        self._noise = SensorNoise(condition, noise_rng)
        self.renderer = OffscreenRenderer(self.model, WIDTH_PX, HEIGHT_PX)
        """Renders the model without noise."""

    def show(self, position_m: np.ndarray, R_world_body: np.ndarray, target_m: np.ndarray) -> None:
        """Brings camera and target to where they are.

        Args:
            position_m: (3,) of the robot, and of its camera.
            R_world_body: (3, 3) attitude of the robot.
            target_m: (3,) middle of the target.
        """
        R_world_camera = R_world_body @ R_BODY_CAMERA
        set_mocap(self.model, self.data, CAMERA, position_m, R_world_camera)
        set_mocap(self.model, self.data, TARGET, target_m, np.eye(3))
        update_poses(self.model, self.data)

    def photograph(
        self, position_m: np.ndarray, R_world_body: np.ndarray, target_m: np.ndarray
    ) -> np.ndarray:
        """(h, w, 3) uint8 RGB image; arguments as in `show`."""
        self.show(position_m, R_world_body, target_m)
        rgb, depth_m = self.renderer.render(self.model, self.data, CAMERA)
        window = slice(0, HEIGHT_PX), slice(0, WIDTH_PX)
        return self._noise.draw()(lambda _: (rgb, depth_m), window)[0]

    def reference_photograph(self) -> np.ndarray:
        """(h, w, 3) uint8 RGB of the target alone, as a user would photograph it beforehand."""
        ahead = np.array([self.config.target_radius_m * FOCAL_PX / _REFERENCE_PX, 0.0, 0.0])
        image = self.photograph(np.zeros(3), np.eye(3), ahead)
        half = _REFERENCE_PX // 2
        rows, columns = HEIGHT_PX // 2, WIDTH_PX // 2
        return image[rows - half : rows + half, columns - half : columns + half]

    def close(self) -> None:
        """Frees the OpenGL context."""
        self.renderer.close()


def hang_crates(config: HallConfig, rng: np.random.Generator) -> np.ndarray:
    """(n, 4) centres and half edges of crates that touch neither wall nor clear part.

    Crates may touch each other.
    """
    hall, clear = np.array(config.hall_m), np.array(config.clear_m)
    middle = np.array([0.0, 0.0, config.clear_height_m])
    crates: list[np.ndarray] = []
    while len(crates) < config.crate_count:
        half = 0.5 * rng.uniform(*config.crate_m)
        centre = rng.uniform(half - hall, hall - half)
        if (np.abs(centre - middle) > clear + half).any():
            crates.append(np.append(centre, half))
    return np.array(crates).reshape(-1, 4)


def _compile(config: HallConfig, crates_m: np.ndarray, rng: np.random.Generator) -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    set_up(spec, clip_m=(0.05, 4.0 * max(config.hall_m)), ambient=0.62)
    add_light(spec, "lamp", 0.38, dir=[0.35, 0.25, -0.9], castshadow=False)
    camera = spec.worldbody.add_body(name=CAMERA, mocap=True)
    camera.add_camera(name=CAMERA, quat=MUJOCO_QUAT, fovy=fovy_deg(HEIGHT_PX, FOCAL_PX))
    target = spec.worldbody.add_body(name=TARGET, mocap=True)
    paint = [*config.target_rgb, 1.0]
    spec.add_material(name=TARGET, rgba=paint, specular=0.0, shininess=0.0)
    target.add_geom(
        name=TARGET,
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[config.target_radius_m, 0.0, 0.0],
        material=TARGET,
        **UNTOUCHABLE,
    )
    _add_walls(spec, config, rng)
    if len(crates_m):
        _add(spec, "crates", _crates(crates_m, rng), labels(_TILE_PX, _TILES, rng))
    return spec.compile()


@dataclass(frozen=True, eq=False)
class _Faces:
    """Squares and rectangles in one mesh."""

    corners_m: np.ndarray
    """(n, 4, 3), counter-clockwise as seen from the side that shows."""
    texture: np.ndarray
    """(n, 4, 2) texture coordinates of the corners."""


_SIDES = np.array(
    [[[s, -s, -1], [s, s, -1], [s, s, 1], [s, -s, 1]] for s in (1, -1)],
    float,
)
"""(2, 4, 3) the faces of a cube at +x and -x, counter-clockwise from outside."""
_CUBE = np.concatenate([np.roll(_SIDES, turn, axis=2) for turn in range(3)])
"""(6, 4, 3): a cyclic change of the axes keeps the sense of rotation."""
_SQUARE = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], float)


def _crates(crates_m: np.ndarray, rng: np.random.Generator) -> _Faces:
    """Every face of every crate shows one of the labels, turned by any quarter."""
    corners = crates_m[:, None, None, :3] + crates_m[:, None, None, 3:] * _CUBE
    corners = corners.reshape(-1, 4, 3)
    side = round(_TILES**0.5)
    tiles = rng.integers(_TILES, size=len(corners))
    turned = _SQUARE[(np.arange(4) + rng.integers(4, size=(len(corners), 1))) % 4]
    place = np.column_stack([tiles % side, tiles // side])
    return _Faces(corners, (place[:, None] + turned) / side)


def _add_walls(spec: mujoco.MjSpec, config: HallConfig, rng: np.random.Generator) -> None:
    """The six walls, each with a mural of its own, seen from inside."""
    for number, face in enumerate(_CUBE):
        corners = (face * config.hall_m)[::-1]
        width_m, height_m = np.linalg.norm(np.diff(corners[:3], axis=0), axis=1)
        size_px = round(width_m * config.wall_px_per_m), round(height_m * config.wall_px_per_m)
        picture = mural(size_px, config.blob_pitch_m * config.wall_px_per_m, rng)
        _add(spec, f"wall{number}", _Faces(corners[None], _SQUARE[None]), picture)


def _add(spec: mujoco.MjSpec, name: str, faces: _Faces, picture: np.ndarray) -> None:
    """A fixed mesh with a picture on it."""
    count = len(faces.corners_m)
    a, b, _, d = np.moveaxis(faces.corners_m, 1, 0)
    normals = np.cross(b - a, d - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    triangles = 4 * np.arange(count)[:, None, None] + [[0, 1, 2], [0, 2, 3]]
    spec.add_mesh(
        name=name,
        uservert=faces.corners_m.ravel().tolist(),
        usernormal=np.repeat(normals, 4, axis=0).ravel().tolist(),
        usertexcoord=faces.texture.ravel().tolist(),
        userface=triangles.ravel().tolist(),
        userfacenormal=triangles.ravel().tolist(),
        userfacetexcoord=triangles.ravel().tolist(),
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
    )
    height, width = picture.shape[:2]
    texture = spec.add_texture(
        name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, width=width, height=height, nchannel=3
    )
    texture.data = picture.tobytes()
    add_material(spec, name)
    spec.worldbody.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_MESH,
        meshname=name,
        material=name,
        **UNTOUCHABLE,
    )
