"""The simulated world: UR5, gripper, conveyor, RGB-D camera, physics of success, and the servo."""

import contextlib
import ctypes
import os
from pathlib import Path

# MuJoCo chooses its OpenGL back end at the first import of mujoco or dm_control.
os.environ.setdefault("MUJOCO_GL", "egl")
if os.environ["MUJOCO_GL"] in ("egl", "osmesa"):
    os.environ.setdefault("PYOPENGL_PLATFORM", os.environ["MUJOCO_GL"])

ASSETS = Path(__file__).resolve().parent.parent / "assets"
"""Folder of MJCF models and meshes; the same place in a checkout and in an installed wheel."""


class OffscreenGLError(RuntimeError):
    """Raised where nothing can be rendered without a display; the message says what to install."""


def require_offscreen_gl() -> None:
    """Raises OffscreenGLError where importing mujoco would fail with a puzzling AttributeError.

    Every package of this one that needs mujoco calls it first.
    """
    if os.environ["MUJOCO_GL"] != "egl":
        return
    try:
        ctypes.CDLL("libEGL.so.1")
        for name in ("libOpenGL.so.0", "libGL.so.1"):
            with contextlib.suppress(OSError):
                ctypes.CDLL(name)
                return
        raise OSError("neither libOpenGL.so.0 nor libGL.so.1 can be loaded")
    except OSError as error:
        raise OffscreenGLError(
            f"offscreen rendering is not possible ({error}); on Debian or Ubuntu: apt-get install "
            "-y --no-install-recommends libegl1 libgl1 libopengl0 libgl1-mesa-dri"
        ) from error
