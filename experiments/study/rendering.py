"""Whether this machine can render without a display, and what does it."""

import importlib
from functools import cache
from typing import Any

PACKAGES = "libegl1 libgl1 libopengl0 libgl1-mesa-dri"
"""Debian and Ubuntu packages that offscreen rendering needs."""


@cache
def gl_renderer() -> str:
    """Name of the OpenGL renderer, such as `llvmpipe (LLVM 15.0.6, 256 bits)`.

    Raises sim.OffscreenGLError, which names the packages to install, where no image can be made.
    """
    from sim import OffscreenGLError

    try:
        import mujoco

        context = mujoco.GLContext(16, 16)
        context.make_current()
        GL: Any = importlib.import_module("OpenGL.GL")
        name = GL.glGetString(GL.GL_RENDERER)
        context.free()
    except Exception as error:
        raise OffscreenGLError(
            f"offscreen rendering is not possible ({type(error).__name__}: {error}); "
            f"on Debian or Ubuntu: apt-get install -y --no-install-recommends {PACKAGES}"
        ) from error
    return name.decode() if isinstance(name, bytes) else str(name)
