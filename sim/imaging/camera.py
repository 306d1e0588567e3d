"""One-pass RGB-D camera: named views, intrinsics, extrinsics and offscreen rendering.

Colour and depth come from one render and one read, which costs half of two renders. Depth is
exact only without multisampling, so the arena compiles with `offsamples="0"`; a context that
samples more is refused.

An exposure keeps what the camera saw; its pixels are made later, and only the window of them that
somebody looks at. In software most of a picture's cost is its pixels.
"""

import contextlib
import importlib
import math
import os
import time
from collections.abc import Generator
from dataclasses import dataclass
from typing import Any, Self, TypeAlias, cast

import mujoco
import numpy as np
from OpenGL import GL

from sim.checks import look_up
from sim.geometry import intrinsics, look_at


@dataclass(frozen=True)
class CameraView:
    """Where a fixed camera stands and how wide it looks."""

    description: str
    position_m: tuple[float, float, float]
    look_at_m: tuple[float, float, float]
    fovy_rad: float
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """World direction that points up in the image."""

    @property
    def T_world_camera(self) -> np.ndarray:
        """(4, 4) pose of the camera in the world; x right, y down, z forward (OpenCV)."""
        return look_at(self.position_m, self.look_at_m, self.up)

    def intrinsics(self, width_px: int, height_px: int) -> np.ndarray:
        """(3, 3) matrix K; pixel centres lie at integer coordinates."""
        return intrinsics(width_px, height_px, self.fovy_rad)


CAMERAS: dict[str, CameraView] = {
    "far-side": CameraView(
        description="oblique view across the belt towards the robot; the hand hides little",
        position_m=(1.50, 0.0, 1.15),
        look_at_m=(0.50, 0.0, 0.0),
        fovy_rad=math.radians(50.0),
    ),
    "kinect": CameraView(
        description="a Kinect v2 across the belt: wider, so nearer than far-side",
        position_m=(1.40, 0.0, 1.02),
        look_at_m=(0.50, 0.0, 0.0),
        fovy_rad=math.radians(60.0),
    ),
    "overhead": CameraView(
        description="straight down on the belt; the hand hides the object while it grasps",
        position_m=(0.50, 0.0, 1.75),
        look_at_m=(0.50, 0.0, 0.0),
        up=(-1.0, 0.0, 0.0),
        fovy_rad=math.radians(45.0),
    ),
}

STUDIO = CameraView(
    description="three-quarter view of the whole cell, for videos",
    position_m=(1.55, -1.35, 1.05),
    look_at_m=(0.30, -0.05, 0.20),
    fovy_rad=math.radians(45.0),
)


def get_view(name: str) -> CameraView:
    """Returns the named view; ValueError for an unknown name."""
    return look_up("camera", name, CAMERAS)


def add_camera(mjcf_root: Any, name: str, view: CameraView) -> Any:
    """Adds `view` to a PyMJCF model and returns the camera element."""
    R = view.T_world_camera[:3, :3]
    return mjcf_root.worldbody.add(
        "camera",
        name=name,
        pos=view.position_m,
        xyaxes=np.concatenate([R[:, 0], -R[:, 1]]),
        fovy=math.degrees(view.fovy_rad),
    )


Window: TypeAlias = tuple[slice, slice]
"""Rows and columns of an image, each a slice with a start and a stop within it."""


@dataclass(frozen=True, eq=False)
class Exposure:
    """What a camera saw at one moment, not yet turned into pixels."""

    scene: mujoco.MjvScene
    """Geometry and lights, which later physics steps do not touch."""
    shape_px: tuple[int, int]
    """Rows and columns of the whole image."""
    clip_m: tuple[float, float]
    """Distances of the near and the far plane."""


class OffscreenRenderer:
    """Renders any camera of a compiled model without a display; one OpenGL context each.

    Close it when done: Mesa prints errors for contexts that outlive the interpreter.
    """

    def __init__(self, model: mujoco.MjModel, width_px: int, height_px: int) -> None:
        self._gl: Any = _gl_context(width_px, height_px)
        self._gl.make_current()
        self.gl_renderer = cast(bytes, GL.glGetString(GL.GL_RENDERER)).decode()
        """Name of what renders, such as `llvmpipe (LLVM 15.0.6, 256 bits)`."""
        self.spent_s = 0.0
        """Wall-clock time of all pixels so far."""
        model.vis.global_.offwidth = max(width_px, int(model.vis.global_.offwidth))
        model.vis.global_.offheight = max(height_px, int(model.vis.global_.offheight))
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        if self._context.offSamples:
            raise ValueError(
                f"offsamples must be 0 for exact depth, got {self._context.offSamples}"
            )
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        self._option = mujoco.MjvOption()
        self._option.sitegroup[:] = 0
        self._camera = mujoco.MjvCamera()
        self._camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
        self.resize(width_px, height_px)

    def resize(self, width_px: int, height_px: int) -> None:
        """Sets the size of the images to come; ValueError beyond the framebuffer's."""
        largest = self._context.offWidth, self._context.offHeight
        if not (0 < width_px <= largest[0] and 0 < height_px <= largest[1]):
            raise ValueError(
                f"image must be at most {largest[0]} x {largest[1]} px, "
                f"got {width_px} x {height_px}"
            )
        self._shape_px = height_px, width_px

    def expose(
        self, model: mujoco.MjModel, data: mujoco.MjData, camera_name: str, *, shadows: bool = False
    ) -> Exposure:
        """What the named camera sees now."""
        scene = mujoco.MjvScene(model, maxgeom=model.ngeom + _OTHER_GEOMS)
        scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = shadows
        self._camera.fixedcamid = model.camera(camera_name).id
        mujoco.mjv_updateScene(
            model, data, self._option, None, self._camera, mujoco.mjtCatBit.mjCAT_ALL, scene
        )
        extent = model.stat.extent
        clip_m = model.vis.map.znear * extent, model.vis.map.zfar * extent
        return Exposure(scene, self._shape_px, clip_m)

    def develop(
        self, exposure: Exposure, window: Window | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """The pixels of an exposure.

        Args:
            exposure: Made by this renderer.
            window: The part of the image that is wanted; all of it if None. A pixel may differ by
                a grey level from that of the whole image.

        Returns:
            (h, w, 3) uint8 colours and (h, w) float32 depth [m] along the optical axis.
        """
        started_s = time.perf_counter()
        rows, columns = window or (slice(0, exposure.shape_px[0]), slice(0, exposure.shape_px[1]))
        height, width = rows.stop - rows.start, columns.stop - columns.start
        rgb = np.empty((height, width, 3), np.uint8)
        depth = np.empty((height, width), np.float32)
        if height and width:
            self._gl.make_current()
            rectangle = mujoco.MjrRect(0, 0, width, height)
            with _narrowed(exposure, rows, columns):
                mujoco.mjr_render(rectangle, exposure.scene, self._context)
            mujoco.mjr_readPixels(rgb, depth, rectangle, self._context)
            _linearise_depth(depth, *exposure.clip_m)
        self.spent_s += time.perf_counter() - started_s
        return rgb[::-1], depth[::-1]

    def render(
        self, model: mujoco.MjModel, data: mujoco.MjData, camera_name: str, *, shadows: bool = False
    ) -> tuple[np.ndarray, np.ndarray]:
        """The whole image of the named camera now; see `develop`."""
        return self.develop(self.expose(model, data, camera_name, shadows=shadows))

    def segment(
        self, model: mujoco.MjModel, data: mujoco.MjData, camera_name: str
    ) -> tuple[np.ndarray, np.ndarray]:
        """What each pixel of the named camera shows.

        Returns:
            (h, w) types (`mujoco.mjtObj`) and (h, w) indices of the objects; -1 where none is.
        """
        exposure = self.expose(model, data, camera_name)
        scene = exposure.scene
        for flag in (mujoco.mjtRndFlag.mjRND_SEGMENT, mujoco.mjtRndFlag.mjRND_IDCOLOR):
            scene.flags[flag] = True
        colours = self.develop(exposure)[0].astype(np.int32)
        segment = colours[..., 0] + (colours[..., 1] << 8) + (colours[..., 2] << 16)
        names = np.full((2, scene.ngeom + 1), -1, np.int32)
        for geom in scene.geoms[: scene.ngeom]:
            names[:, geom.segid + 1] = geom.objtype, geom.objid
        return names[0][segment], names[1][segment]

    def close(self) -> None:
        """Frees the OpenGL context; a second call does nothing."""
        if self._gl is not None:
            self._gl.make_current()
            self._context.free()
            self._gl.free()
            self._gl = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


_OTHER_GEOMS = 64
"""Room for what is drawn beside the model's geoms: pieces of tendons and lamps."""


@contextlib.contextmanager
def _narrowed(exposure: Exposure, rows: slice, columns: slice) -> Generator[None, None, None]:
    """Inside, the cameras of the exposure look through the window alone: off-centre frusta."""
    height_px, width_px = exposure.shape_px
    cameras = exposure.scene.camera
    whole = [(c.frustum_bottom, c.frustum_top, c.frustum_center, c.frustum_width) for c in cameras]
    for camera, (bottom, top, centre, _) in zip(cameras, whole, strict=True):
        px = (top - bottom) / height_px
        camera.frustum_bottom, camera.frustum_top = top - px * rows.stop, top - px * rows.start
        middle = 0.5 * (columns.start + columns.stop - width_px)
        camera.frustum_center = centre + px * middle
        camera.frustum_width = 0.5 * px * (columns.stop - columns.start)
    yield
    for camera, (bottom, top, centre, width) in zip(cameras, whole, strict=True):
        camera.frustum_bottom, camera.frustum_top = bottom, top
        camera.frustum_center, camera.frustum_width = centre, width


def _gl_context(width_px: int, height_px: int) -> Any:
    """A context of the platform that MUJOCO_GL names.

    `mujoco.GLContext` obeys the variable only if it was set before mujoco's first import.
    """
    platform = importlib.import_module(f"mujoco.{os.environ['MUJOCO_GL']}")
    return platform.GLContext(width_px, height_px)


def _linearise_depth(buffer: np.ndarray, near_m: float, far_m: float) -> None:
    """Turns a zero-far depth buffer into metres in place.

    Source: OpenGL perspective projection with a clip depth of 1 at the near plane and 0 at the
    far one.
    """
    offset = near_m / (far_m - near_m)
    buffer += np.float32(offset)
    np.divide(np.float32(far_m * offset), buffer, out=buffer)
