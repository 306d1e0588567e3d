"""What every scene that is built as an MjSpec needs: set-up, lights, pictures, and poses."""

from typing import Any

import cv2
import mujoco
import numpy as np
from numpy.typing import ArrayLike

from sim.geometry import quaternion

UNTOUCHABLE = {"contype": 0, "conaffinity": 0}
"""Settings of a geom that is only looked at."""

_QUICK = [cv2.IMWRITE_PNG_COMPRESSION, 1]


def set_up(spec: Any, clip_m: tuple[float, float], ambient: float, extent_m: float = 1.0) -> None:
    """Sets what a camera needs: its near and far plane, exact depth, and light from everywhere.

    Args:
        spec: The MjSpec of the scene.
        clip_m: Distances of the near and the far plane, in units of `extent_m`.
        ambient: Brightness of the light from everywhere.
        extent_m: Size of the scene; MuJoCo computes one where none is given.
    """
    spec.stat.extent = extent_m
    spec.visual.map.znear, spec.visual.map.zfar = clip_m
    spec.visual.quality.offsamples = 0
    spec.visual.headlight.ambient = [ambient] * 3
    spec.visual.headlight.diffuse = spec.visual.headlight.specular = [0.0] * 3


def add_light(spec: Any, name: str, brightness: float, **settings: Any) -> Any:
    """Adds a light that is directional and lights matt what faces it alone; returns it."""
    white = {"diffuse": [brightness] * 3, "ambient": [0.0] * 3, "specular": [0.0] * 3}
    kind = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    return spec.worldbody.add_light(**({"name": name, "type": kind} | white | settings))


def add_files(spec: Any, pictures: dict[str, np.ndarray]) -> None:
    """Hands (h, w, 3) uint8 pictures to the compiler as PNG files in memory, by file name."""
    encoded = {
        file: cv2.imencode(".png", picture[..., ::-1], _QUICK)[1].tobytes()
        for file, picture in pictures.items()
    }
    spec.assets = dict(spec.assets) | encoded


def add_material(spec: Any, name: str, specular: float = 0.0, shininess: float = 0.0) -> Any:
    """Adds a material that shows the texture of the same name, and returns it."""
    material = spec.add_material(name=name, specular=specular, shininess=shininess)
    textures = list(material.textures)
    textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
    material.textures = textures
    return material


def add_picture(spec: Any, name: str, picture: np.ndarray, *finish: float) -> Any:
    """Adds a texture and its material; `finish` is the material's specular and shininess."""
    add_files(spec, {f"{name}.png": picture})
    spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, file=f"{name}.png")
    return add_material(spec, name, *finish)


def set_mocap(model: Any, data: Any, body: str, position_m: ArrayLike, R: np.ndarray) -> None:
    """Puts a mocap body at a position (3,) and rotation (3, 3) in the world."""
    index = model.body(body).mocapid[0]
    data.mocap_pos[index] = position_m
    data.mocap_quat[index] = quaternion(R)


def update_poses(model: Any, data: Any) -> None:
    """Brings bodies, cameras and lights to where the state puts them, without any dynamics."""
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_camlight(model, data)
