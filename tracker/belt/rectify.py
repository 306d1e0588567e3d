"""A virtual overhead camera: the image resampled onto a horizontal plane at a constant scale.

On the plane of the object's top face a calibrated camera turns into an orthographic one: the face
then moves as a rigid patch, with no perspective change for the filter to follow. Depth shows where
something stands above the plane and hides it.

Frames: camera axes are x right, y down, z forward (OpenCV); pixel centres lie at integers. In the
overhead image the column grows with world y and the row with world x, which is the view from above
(not mirrored).
"""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from tracker.belt.image import CameraImage, Window
from tracker.checks import require_positive


@dataclass(frozen=True, eq=False)
class OverheadImage:
    """One camera image resampled to the plane."""

    grey: np.ndarray
    """(rows, columns) uint8."""
    visibility: np.ndarray
    """(rows, columns) uint8: 1 where the plane may be seen, 0 if hidden or outside the image."""
    height_m: np.ndarray
    """(rows, columns) float32 height of the seen surface above the plane; NaN without depth."""


@dataclass(frozen=True, eq=False)
class OverheadView:
    """Geometry of the virtual camera, fixed for one camera pose and plane height."""

    K: np.ndarray
    """(3, 3) camera intrinsics."""
    T_world_camera: np.ndarray
    """(4, 4) pose of the camera in the world."""
    image_shape_px: tuple[int, int]
    """Rows and columns of the camera image."""
    plane_z_m: float = 0.08
    """World height of the plane: the top face of the object."""
    x_range_m: tuple[float, float] = (0.28, 0.72)
    """World x from the first to the last row."""
    y_range_m: tuple[float, float] = (-0.85, 0.85)
    """World y from the first to the last column."""
    m_per_px: float = 0.003
    """Size of an overhead pixel."""
    occluder_height_m: float = 0.015
    """A surface higher than this above the plane hides what is below, where depth shows it."""
    depth_noise_m: float = 0.002
    """Standard deviation of a depth sample, as the sensor's maker declares it."""

    def __post_init__(self) -> None:
        for name, shape in (("K", (3, 3)), ("T_world_camera", (4, 4))):
            array = np.array(getattr(self, name), float)
            if array.shape != shape or not np.isfinite(array).all():
                raise ValueError(f"{name} must be a finite {shape} array, got {array.shape}")
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        if len(self.image_shape_px) != 2 or min(self.image_shape_px) < 2:
            raise ValueError(f"image_shape_px must be (rows, columns), got {self.image_shape_px}")
        for name in ("x_range_m", "y_range_m"):
            low, high = getattr(self, name)
            if not (np.isfinite([low, high]).all() and low < high):
                raise ValueError(f"{name} must be (low, high) with low < high, got {(low, high)}")
        require_positive(self, "m_per_px", "occluder_height_m", "depth_noise_m")
        if self.T_world_camera[2, 3] <= self.plane_z_m:
            raise ValueError(
                f"plane_z_m must lie below the camera at {self.T_world_camera[2, 3]:g} m, "
                f"got {self.plane_z_m!r}"
            )

    @cached_property
    def shape_px(self) -> tuple[int, int]:
        """Rows and columns of the overhead image."""
        rows = round((self.x_range_m[1] - self.x_range_m[0]) / self.m_per_px) + 1
        columns = round((self.y_range_m[1] - self.y_range_m[0]) / self.m_per_px) + 1
        return rows, columns

    @cached_property
    def H_camera_overhead(self) -> np.ndarray:
        """(3, 3) homography from overhead pixels to camera pixels."""
        s = self.m_per_px
        world = np.array(
            [
                [0.0, s, self.x_range_m[0]],
                [s, 0.0, self.y_range_m[0]],
                [0.0, 0.0, self.plane_z_m],
                [0.0, 0.0, 1.0],
            ]
        )
        return self.K @ np.linalg.inv(self.T_world_camera)[:3] @ world

    def rectify(self, image: CameraImage, region: Window | None = None) -> OverheadImage:
        """Resamples an image; an image of another shape than the camera's is all hidden.

        Args:
            image: Depth of 0 or NaN is no return and hides nothing.
            region: Rows and columns of the overhead image that are wanted; the rest is black and
                hidden. All if None. The image is asked only for what they need.
        """
        overhead = OverheadImage(
            grey=np.zeros(self.shape_px, np.uint8),
            visibility=np.zeros(self.shape_px, np.uint8),
            height_m=np.full(self.shape_px, np.nan, np.float32),
        )
        region = region or (slice(0, self.shape_px[0]), slice(0, self.shape_px[1]))
        window = self.window_of(region)
        has_area = all(part.start < part.stop for part in window)
        if tuple(image.shape_px) == tuple(self.image_shape_px) and has_area:
            rgb, depth_m = image.crop(window)
            self._resample(overhead, rgb, depth_m, region, window)
        return overhead

    def window_of(self, region: Window) -> Window:
        """Rows and columns of the camera image that the region of the overhead image needs."""
        rows, columns = region
        ends = np.array(
            [[c, r] for r in (rows.start, rows.stop) for c in (columns.start, columns.stop)]
        )
        q = self.camera_of_pixel(ends)  # a convex region stays convex
        low = np.floor(q.min(axis=0)).astype(int) - _MARGIN_PX
        high = np.ceil(q.max(axis=0)).astype(int) + _MARGIN_PX + 1
        height, width = self.image_shape_px
        (left, top), (right, bottom) = (np.clip(end, 0, [width, height]) for end in (low, high))
        return slice(int(top), int(bottom)), slice(int(left), int(right))

    def _resample(
        self,
        overhead: OverheadImage,
        rgb: np.ndarray,
        depth_m: np.ndarray | None,
        region: Window,
        window: Window,
    ) -> None:
        """Fills the region of `overhead` from the window of the camera image."""
        origin = np.array([window[1].start, window[0].start], np.int16)
        (places, fractions), nearest = self._maps, self._nearest_places
        grey = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY)
        overhead.grey[region] = cv2.remap(
            grey, places[region] - origin, fractions[region], cv2.INTER_LINEAR
        )
        overhead.visibility[region] = self._inside[region]
        if depth_m is None:
            return
        depth = cv2.remap(
            np.asarray(depth_m, np.float32), nearest[region] - origin, _NONE, cv2.INTER_NEAREST
        )
        with np.errstate(invalid="ignore"):
            is_known = depth > 0
            height = self._drop_per_depth[region] * depth
            height += np.float32(self.T_world_camera[2, 3] - self.plane_z_m)
            is_hidden = (height > self._certainly_above_m) & is_known
        height[~is_known] = np.nan
        overhead.height_m[region] = height
        overhead.visibility[region] &= 1 - cv2.dilate(is_hidden.astype(np.uint8), _NEIGHBOURHOOD)

    @property
    def _certainly_above_m(self) -> float:
        """Height above which a sample is hardly the plane's: else a noisy depth hides it all."""
        return max(self.occluder_height_m, _DEVIATIONS * self.depth_noise_m)

    def world_of_pixel(self, pixel: np.ndarray) -> np.ndarray:
        """(..., 3) world points [m] on the plane of overhead pixels (..., 2) (column, row)."""
        pixel = np.asarray(pixel, float)
        world = np.empty((*pixel.shape[:-1], 3))
        world[..., 0] = self.x_range_m[0] + self.m_per_px * pixel[..., 1]
        world[..., 1] = self.y_range_m[0] + self.m_per_px * pixel[..., 0]
        world[..., 2] = self.plane_z_m
        return world

    def camera_of_pixel(self, pixel: np.ndarray) -> np.ndarray:
        """(..., 2) camera pixels of overhead pixels (..., 2), for drawing on the camera image."""
        pixel = np.asarray(pixel, float)
        q = pixel @ self.H_camera_overhead[:, :2].T + self.H_camera_overhead[:, 2]
        return q[..., :2] / q[..., 2:]

    @cached_property
    def _camera_coordinates(self) -> np.ndarray:
        """(rows, columns, 2) camera pixel of every overhead pixel."""
        rows, columns = self.shape_px
        pixel = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1)
        return self.camera_of_pixel(pixel)

    @cached_property
    def _maps(self) -> tuple[np.ndarray, np.ndarray]:
        """Fixed-point maps for `cv2.remap`."""
        q = self._camera_coordinates.astype(np.float32)
        return cv2.convertMaps(q[..., 0], q[..., 1], cv2.CV_16SC2)

    @cached_property
    def _nearest_places(self) -> np.ndarray:
        """Rounded maps: with the fixed-point ones nearest-neighbour sampling would truncate."""
        q = self._camera_coordinates.astype(np.float32)
        return cv2.convertMaps(q[..., 0], q[..., 1], cv2.CV_16SC2, nninterpolation=True)[0]

    @cached_property
    def _inside(self) -> np.ndarray:
        """(rows, columns) uint8, 1 where the overhead pixel lies in the camera image."""
        height, width = self.image_shape_px
        q = self._camera_coordinates
        is_inside = (q >= 0).all(axis=-1) & (q[..., 0] <= width - 1) & (q[..., 1] <= height - 1)
        return is_inside.astype(np.uint8)

    @cached_property
    def _drop_per_depth(self) -> np.ndarray:
        """(rows, columns) world z gained per metre of depth along each pixel's ray."""
        q = self._camera_coordinates
        homogeneous = np.concatenate([q, np.ones_like(q[..., :1])], axis=-1)
        rays = homogeneous @ np.linalg.inv(self.K).T @ self.T_world_camera[:3, :3].T
        return rays[..., 2].astype(np.float32)


_MARGIN_PX = 1
"""Bilinear sampling reads the neighbours."""

_DEVIATIONS = 3.0
"""A normal sample lies higher than this many of its standard deviations once in 740 times."""

_NONE = np.empty((0, 0), np.uint16)
"""Fractions of pixels where the nearest one counts."""

_NEIGHBOURHOOD = np.ones((3, 3), np.uint8)
