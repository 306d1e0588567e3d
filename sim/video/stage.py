"""The MuJoCo model behind a film: everything hangs on mocap bodies, so any instant can be shown.

At rest the camera stands in the world's origin and its image axes are the world's: x right, y down,
z forward. Each actor is a rigid flex; a sheet is deformed by moving the vertices of its flex.
"""

import math
from dataclasses import dataclass, fields
from typing import cast

import mujoco
import numpy as np

from sim.checks import look_up
from sim.geometry import MUJOCO_QUAT, fovy_deg, intrinsics, rotation
from sim.imaging.spec import UNTOUCHABLE, add_light, add_picture, set_mocap, set_up, update_poses
from sim.video import pictures, surfaces
from sim.video.clip import (
    FOCAL_PX,
    HEIGHT_PX,
    WALL_DEPTH_M,
    WIDTH_PX,
    Actor,
    Clip,
    Lighting,
    Moves,
    Shake,
    Signal,
    Terms,
    draw_sum,
)
from sim.video.surfaces import Surface

TARGET = "target"
CAMERA = "camera"
_SCENERY = "scenery"


@dataclass(frozen=True, eq=False)
class _Playing:
    """An actor with its motion drawn and its mesh made."""

    name: str
    script: Actor
    signals: dict[str, Signal]
    surface: Surface

    def pose(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Position (3,) [m] of the local origin and rotation (3, 3) in the world."""
        a, s = self.script, self.signals
        depth = a.depth_m * 2.0 ** -s["zoom_octaves"](time)
        x = a.start_px[0] + s["x_px"](time) - 0.5 * (WIDTH_PX - 1)
        y = a.start_px[1] + s["y_px"](time) - 0.5 * (HEIGHT_PX - 1)
        front = np.array([x / FOCAL_PX, y / FOCAL_PX, 1.0]) * depth
        behind = 0.5 * a.thickness * a.size_m[0] if a.shape == "carton" else 0.0
        R = rotation(s["roll_rad"](time), s["yaw_rad"](time), s["pitch_rad"](time))
        return front + np.array([0.0, 0.0, behind]), R

    def vertices_m(self, time: float) -> np.ndarray:
        """(n, 3) vertices in the local frame."""
        bend, ripple, sway = (self.signals[n](time) for n in ("bend_rad", "ripple", "sway"))
        return surfaces.deformed(self.surface.vertices_m, bend, ripple, sway, time)


class Stage:
    """The compiled scene of one clip.

    Args:
        clip: What is to be seen.
        rng: Draws the motion and the pictures, each from a stream of its own.
        is_painted: Without pictures it is made faster, and moves alike.
    """

    def __init__(self, clip: Clip, rng: np.random.Generator, *, is_painted: bool = True) -> None:
        self.clip = clip
        motion_rng, picture_rng = rng.spawn(2)
        frames = clip.frame_count
        self._actors = [
            _Playing(
                name,
                actor,
                _draw(actor.moves, frames, motion_rng),
                surfaces.make_surface(actor.shape, actor.size_m, actor.thickness),
            )
            for name, actor in _named(clip)
        ]
        self._shake = _draw(clip.shake, frames, motion_rng)
        self._light = _draw(clip.lighting, frames, motion_rng)
        self.model = _compile(clip, self._actors, picture_rng if is_painted else None)
        self.data = mujoco.MjData(self.model)
        self.target: Surface = self._actors[0].surface
        """Mesh of the target."""
        self.show(0.0)

    def show(self, time: float) -> None:
        """Brings everything to where it is at a time [frames]."""
        for actor in self._actors:
            self._place(actor, time)
        pan, tilt = self._shake["pan_rad"](time), self._shake["tilt_rad"](time)
        set_mocap(self.model, self.data, CAMERA, np.zeros(3), rotation(0.0, pan, tilt))
        self._light_up(time)
        update_poses(self.model, self.data)
        mujoco.mj_flex(self.model, self.data)

    def target_vertices_m(self) -> np.ndarray:
        """(n, 3) world positions of the target's vertices, as MuJoCo has them."""
        first = self.model.flex_vertadr[flex_id(self.model, TARGET)]
        return self.data.flexvert_xpos[first : first + len(self.target.vertices_m)].copy()

    def projection(self) -> np.ndarray:
        """(3, 4) matrix from the world to pixels, whose centres are integers, from 0."""
        camera = self.model.camera(CAMERA).id
        R_camera_world = self.data.cam_xmat[camera].reshape(3, 3).T * [[1], [-1], [-1]]
        t = -R_camera_world @ self.data.cam_xpos[camera]
        K = intrinsics(WIDTH_PX, HEIGHT_PX, math.radians(self.model.cam_fovy[camera]))
        return K @ np.column_stack([R_camera_world, t])

    def _place(self, actor: _Playing, time: float) -> None:
        set_mocap(self.model, self.data, actor.name, *actor.pose(time))
        if actor.script.shape == "sheet":
            first = self.model.flex_vertadr[flex_id(self.model, actor.name)]
            vertices = actor.vertices_m(time)
            self.model.flex_vert[first : first + len(vertices)] = vertices

    def _light_up(self, time: float) -> None:
        lighting = self.clip.lighting
        lamp = lighting.lamp * 2.0 ** self._light["lamp_octaves"](time)
        self.model.light("lamp").diffuse[:] = lamp
        if lighting.spot:
            aim = [self._light[f"spot_{axis}_px"](time) * WALL_DEPTH_M / FOCAL_PX for axis in "xy"]
            spot = self.model.light("spot")
            direction = np.array([*aim, WALL_DEPTH_M]) - spot.pos
            spot.dir[:] = direction / np.linalg.norm(direction)


def flex_id(model: mujoco.MjModel, name: str) -> int:
    """Returns the index of a flex."""
    return mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_FLEX, name)


def _named(clip: Clip) -> list[tuple[str, Actor]]:
    others = [(f"other{number}", actor) for number, actor in enumerate(clip.others)]
    return [(TARGET, clip.target), *others]


def _draw(
    script: Moves | Lighting | Shake, frame_count: int, rng: np.random.Generator
) -> dict[str, Signal]:
    """A signal for each field of `script` that holds terms."""
    terms = {field.name: getattr(script, field.name) for field in fields(script)}
    return {
        name: draw_sum(cast(Terms, value), frame_count, rng)
        for name, value in terms.items()
        if isinstance(value, tuple)
    }


def _compile(clip: Clip, actors: list[_Playing], rng: np.random.Generator | None) -> mujoco.MjModel:
    """The model; `rng` paints the pictures, None leaves them away."""
    spec = mujoco.MjSpec()
    set_up(spec, clip_m=(0.05, 20.0), ambient=clip.lighting.ambient)
    _add_lights(spec, clip.lighting)
    body = spec.worldbody.add_body(name=CAMERA, mocap=True)
    body.add_camera(name=CAMERA, quat=MUJOCO_QUAT, fovy=fovy_deg(HEIGHT_PX, FOCAL_PX))
    wall_m = pictures.WALL_MM[0] / 1e3, pictures.WALL_MM[1] / 1e3
    _add(spec, _SCENERY, surfaces.make_wall(wall_m, 49, 65))
    spec.body(_SCENERY).pos = [0.0, 0.0, WALL_DEPTH_M]
    for actor in actors:
        _add(spec, actor.name, actor.surface)
    if rng is not None:
        for name, picture in _paint(clip, rng).items():
            add_picture(spec, name, picture)
            spec.flex(name).material = name
    return spec.compile()


def _paint(clip: Clip, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """The picture of everything, by name."""
    style = pictures.Style.draw(rng)
    painted = {_SCENERY: look_up("scenery", clip.scenery, pictures.SCENERIES)(style, rng)}
    for name, actor in _named(clip):
        is_alike = name == TARGET or actor.artwork == "look-alike"
        own = style if is_alike else pictures.Style.draw(rng)
        paint = pictures.pole if actor.artwork == "pole" else pictures.poster
        size_mm = actor.size_m[0] * 1e3, actor.size_m[1] * 1e3
        painted[name] = paint(own, size_mm, rng)
    return painted


def _add_lights(spec: mujoco.MjSpec, lighting: Lighting) -> None:
    add_light(spec, "lamp", lighting.lamp, dir=[0.25, 0.35, 0.9], castshadow=False)
    if lighting.spot:
        spot = add_light(spec, "spot", lighting.spot, castshadow=False)
        spot.type, spot.cutoff, spot.exponent = mujoco.mjtLightType.mjLIGHT_SPOT, 25.0, 60.0
        spot.pos, spot.attenuation = [-0.3, -0.4, -0.5], [1.0, 0.0, 0.0]


def _add(spec: mujoco.MjSpec, name: str, surface: Surface) -> None:
    """A mocap body that carries the surface."""
    spec.worldbody.add_body(name=name, mocap=True)
    triangles = surface.triangles.ravel().tolist()
    spec.add_flex(
        name=name,
        dim=2,
        radius=1e-5,
        **UNTOUCHABLE,
        flatskin=surface.is_closed,
        vertbody=[name] * len(surface.vertices_m),
        vert=surface.vertices_m.ravel().tolist(),
        elem=triangles,
        texcoord=surface.texture.ravel().tolist(),
        elemtexcoord=triangles,
    )
