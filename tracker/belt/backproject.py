"""From a warp in the overhead image, and depth, to the pose of the target's top face.

Source: the 3-D reconstruction module of [IGPFPatent]. Occlusion gives bias, not noise, so a pose
from too little of the target, or of a size that is not the target's, is marked not usable.
"""

import math
from dataclasses import dataclass

import numpy as np

from tracker.affine import aff2
from tracker.affine.template import Template
from tracker.base import Status, WarpEstimate
from tracker.belt.rectify import OverheadImage, OverheadView
from tracker.checks import require_count, require_positive, require_share


@dataclass(frozen=True)
class BackprojectConfig:
    """Gates and noise of the reconstruction."""

    min_visible_fraction: float = 0.35
    """Visible share of the template from which a pose is usable."""
    max_size_error: float = 0.08
    """Largest relative deviation of the fitted from the known size."""
    max_height_error_m: float = 0.02
    """The top face is never further than this from the nominal plane."""
    height_gain: float = 0.2
    """Share of a new height measurement that enters the running height."""
    min_depth_count: int = 20
    """Depth samples on the target without which the running height is kept."""

    def __post_init__(self) -> None:
        require_share(self, "min_visible_fraction", "max_size_error", "height_gain")
        require_positive(self, "max_height_error_m")
        require_count(self, "min_depth_count")


@dataclass(frozen=True, eq=False)
class TargetPose:
    """Pose of the centre of the target's top face."""

    position_m: np.ndarray
    """(3,) in the world."""
    yaw_rad: float
    """Angle of the target's long axis (the template's u axis) about world z, in (-pi, pi]."""
    covariance: np.ndarray
    """(4, 4) of x, y, z [m] and yaw [rad] in the world."""
    time_s: float
    """When the image was exposed."""
    visible_fraction: float
    """Share of the top face that was seen."""
    is_usable: bool
    """False if too little was seen, or the fit does not have the target's size."""
    position_camera_m: np.ndarray | None = None
    """(3,) in the camera, x right, y down, z forward; None where no camera was involved."""

    def __post_init__(self) -> None:
        for name in ("position_m", "position_camera_m", "covariance"):
            array = getattr(self, name)
            if array is not None:
                array.setflags(write=False)


class Backprojector:
    """Turns warp estimates of one target into poses; keeps a running height of its top face."""

    def __init__(self, template: Template, view: OverheadView, config: BackprojectConfig) -> None:
        self._points = template.points
        self._view = view
        self._config = config
        self._T_camera_world = np.linalg.inv(view.T_world_camera)
        self._height_m = 0.0
        self._has_height = False

    def reset(self) -> None:
        """Forgets the running height, for a new target."""
        self._height_m, self._has_height = 0.0, False

    def pose(
        self, estimate: WarpEstimate, image: OverheadImage, unit_px: float, time_s: float
    ) -> TargetPose | None:
        """Pose of the target, or None when the warp is no valid place."""
        if not aff2.is_valid(estimate.warp) or not np.isfinite(estimate.covariance).all():
            return None
        parameters = aff2.polar(estimate.warp)
        if not np.isfinite(parameters).all():
            return None
        depth_count = self._measure_height(estimate.warp, image)
        position = self._lift(self._view.world_of_pixel(parameters[4:]))
        R, t = self._T_camera_world[:3, :3], self._T_camera_world[:3, 3]
        size_error = np.abs(np.expm1(parameters[0] - math.log(unit_px) + _corners(parameters)))
        is_usable = (
            estimate.status is Status.TRACKING
            and estimate.visible_fraction >= self._config.min_visible_fraction
            and bool((size_error <= self._config.max_size_error).all())
        )
        return TargetPose(
            position_m=position,
            position_camera_m=R @ position + t,
            yaw_rad=_wrapped(0.5 * math.pi - parameters[2]),
            covariance=self._covariance(estimate, depth_count),
            time_s=time_s,
            visible_fraction=estimate.visible_fraction,
            is_usable=is_usable,
        )

    def _measure_height(self, warp: np.ndarray, image: OverheadImage) -> int:
        """Updates the running height from the visible samples; returns their number."""
        pixel = np.rint(warp[:2] @ self._points).astype(int)
        rows, columns = image.grey.shape
        is_in = (pixel >= 0).all(axis=0) & (pixel[0] < columns) & (pixel[1] < rows)
        column, row = pixel[:, is_in]
        limit = self._config.max_height_error_m
        height = image.height_m[row, column]
        height = height[(image.visibility[row, column] > 0) & (np.abs(height) < limit)]
        if len(height) >= self._config.min_depth_count:
            median = float(np.median(height))
            gain = self._config.height_gain if self._has_height else 1.0
            self._height_m += gain * (median - self._height_m)
            self._has_height = True
        return len(height)

    def _lift(self, on_plane: np.ndarray) -> np.ndarray:
        """(3,) point at the running height on the camera ray through a point of the plane."""
        camera = self._view.T_world_camera[:3, 3]
        share = (camera[2] - self._view.plane_z_m - self._height_m) / (camera[2] - on_plane[2])
        return camera + share * (on_plane - camera)

    def _covariance(self, estimate: WarpEstimate, depth_count: int) -> np.ndarray:
        """(4, 4) by first-order propagation of the warp covariance."""
        J = np.zeros((3, 6))
        s = self._view.m_per_px
        J[0, 4:] = s * estimate.warp[1, :2]
        J[1, 4:] = s * estimate.warp[0, :2]
        J[2, 2] = -1.0
        planar = J @ estimate.covariance @ J.T
        covariance = np.zeros((4, 4))
        axes = [0, 1, 3]
        covariance[np.ix_(axes, axes)] = planar
        samples = max(depth_count, 1) / 10.0
        covariance[2, 2] = self._view.depth_noise_m**2 / max(samples, 1.0)
        return covariance


def _corners(parameters: np.ndarray) -> np.ndarray:
    """(2,) extreme log stretches of the fitted shape beside its mean scale."""
    stretch = math.hypot(parameters[1], parameters[3])
    return np.array([-stretch, stretch])


def _wrapped(angle_rad: float) -> float:
    return math.pi - (math.pi - angle_rad) % (2.0 * math.pi)
