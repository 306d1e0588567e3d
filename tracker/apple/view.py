"""What one image shows of a fruit, and where the camera was: all that an estimator gets.

Frames: images in OpenCV pixels (u to the right, v down, the centre of the first pixel at 0, 0);
the camera with x right, y down and z forward; the robot's base, in which attitudes are stated.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

_UNIT_TOLERANCE = 1e-6


class FruitStatus(StrEnum):
    """What became of the search for a fruit in one image; only the first has an ellipse to use."""

    FOUND = "found"
    NO_FRUIT = "no-fruit"
    CUT_BY_BORDER = "cut-by-border"
    """The fruit touches the border of the image."""
    TWO_FRUITS = "two-fruits"
    """A second region is nearly as large as the largest."""
    COVERED = "covered"
    """Too little of the outline is in sight for an ellipse."""
    CALYX_OUTSIDE = "calyx-outside"
    """What looks like the calyx lies outside the outline of the fruit."""


@dataclass(frozen=True, eq=False)
class FruitView:
    """What one image shows of the fruit, in pixels."""

    status: FruitStatus
    centre_px: np.ndarray | None = None
    """(2,) u, v of the centre of the ellipse fitted to the outline; with status FOUND."""
    semi_axes_px: np.ndarray | None = None
    """(2,) its major and its minor semi-axis; with status FOUND."""
    major_angle_rad: float | None = None
    """Direction of the major axis, from +u towards +v, in [0, pi); with status FOUND."""
    calyx_px: np.ndarray | None = None
    """(2,) centroid of the visible calyx; None when none is in sight."""
    arc_fraction: float = 1.0
    """Share of the ellipse to which outline points were fitted; 1 is all, leaves in front take."""
    contour_px: np.ndarray = field(default_factory=lambda: np.empty((0, 2)))
    """(n, 2) points on the fruit's own outline, in any order: none where a leaf or the stem bounds
    the region. At best evenly spaced, a few dozen to a few hundred, to sub-pixel accuracy."""
    skin_px: np.ndarray = field(default_factory=lambda: np.empty((0, 2)))
    """(m, 2) sparse grid of pixels at which the fruit's skin is in sight, so that no calyx is
    there; may be empty. `skin_step_px` apart in both directions."""
    skin_step_px: float = 0.0
    """Spacing of `skin_px`."""
    ellipse_covariance: np.ndarray | None = None
    """(5, 5) of u, v [px], log major, log minor semi-axis and the angle [rad]; None if unknown."""

    def __post_init__(self) -> None:
        if self.is_found:
            _require_ellipse(self)
        if not 0.0 <= self.arc_fraction <= 1.0:
            raise ValueError(f"arc_fraction must be in [0, 1], got {self.arc_fraction!r}")
        if self.calyx_px is not None:
            _require_array("calyx_px", self.calyx_px, (2,))
        if self.ellipse_covariance is not None:
            _require_array("ellipse_covariance", self.ellipse_covariance, (5, 5))
        for name in ("contour_px", "skin_px"):
            points = getattr(self, name)
            _require_array(name, points, (len(points), 2))
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    @property
    def is_found(self) -> bool:
        """Whether there is an ellipse to use."""
        return self.status is FruitStatus.FOUND


@dataclass(frozen=True, eq=False)
class CameraPose:
    """Pose of the camera (x right, y down, z forward) in the robot's base frame."""

    rotation: np.ndarray
    """(3, 3) camera -> robot; its columns are the camera's axes in the robot's frame."""
    position_m: np.ndarray
    """(3,) of the optical centre in the robot's frame."""

    def __post_init__(self) -> None:
        _require_array("rotation", self.rotation, (3, 3))
        _require_array("position_m", self.position_m, (3,))
        error = float(np.abs(self.rotation.T @ self.rotation - np.eye(3)).max())
        if error > _UNIT_TOLERANCE or np.linalg.det(self.rotation) < 0.0:
            raise ValueError(
                "rotation must have orthonormal columns of unit length and determinant +1, got "
                f"determinant {np.linalg.det(self.rotation):.6g}, deviation {error:.3g}"
            )
        self.rotation.setflags(write=False)
        self.position_m.setflags(write=False)


@dataclass(frozen=True, eq=False)
class Sighting:
    """One view, the camera that took it, and where that was."""

    view: FruitView
    K: np.ndarray
    """(3, 3) intrinsics [px], without skew."""
    pose: CameraPose

    def __post_init__(self) -> None:
        _require_array("K", self.K, (3, 3))
        is_camera = self.K[0, 0] > 0 and self.K[1, 1] > 0 and self.K[2, 2] == 1.0
        if not is_camera or self.K[0, 1] != 0 or self.K[1, 0] != 0 or self.K[2, :2].any():
            raise ValueError(
                "K must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] with fx and fy above 0, got "
                f"{self.K.tolist()}"
            )
        self.K.setflags(write=False)


def found(sightings: Sequence[Sighting]) -> list[Sighting]:
    """Returns the sightings with a fruit to use."""
    return [sighting for sighting in sightings if sighting.view.is_found]


def _require_ellipse(view: FruitView) -> None:
    if view.centre_px is None or view.semi_axes_px is None or view.major_angle_rad is None:
        raise ValueError("a found fruit needs centre_px, semi_axes_px and major_angle_rad")
    _require_array("centre_px", view.centre_px, (2,))
    _require_array("semi_axes_px", view.semi_axes_px, (2,))
    major, minor = view.semi_axes_px
    if not major >= minor > 0:
        raise ValueError(f"semi_axes_px must be major >= minor > 0, got {major}, {minor}")
    if not 0.0 <= view.major_angle_rad < math.pi:
        raise ValueError(f"major_angle_rad must be in [0, pi), got {view.major_angle_rad!r}")


def _require_array(name: str, array: np.ndarray, shape: tuple[int, ...]) -> None:
    if array.shape != shape:
        raise ValueError(f"{name} must have the shape {shape}, got {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} must be finite, got {array.tolist()}")
