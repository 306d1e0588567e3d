"""What goes into one iteration and what comes out: pixels and odometry in, a motion command out.

One iteration k, the same for a simulated measurement and for one from a rendered image:

1. The vehicle has carried out the last command. `Measurements.odometry` is what it believes to
   have moved, in its own frame: the command itself, or wheel or inertial readings. Zero at k = 0.
2. The camera is read at the new pose: `Measurements.features` and `Measurements.target_px`.
3. `BearingPilot.step(measurements)` predicts, updates and answers with the `MotionCommand` for the
   next time step.

All arrays may carry a leading axis of independent runs, except feature observations.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, Self, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tracker.checks import require_positive
from tracker.geometry import R_BODY_CAMERA, project, rays_of

Status: TypeAlias = Literal["tracking", "predicting", "lost"]
"""Target seen now; not seen for a while and predicted; not seen for so long that it is given up."""


@dataclass(frozen=True)
class PinholeCamera:
    """A camera without distortion, of [Wu2022] Table 1 (whose image width 648 is 640)."""

    s_u_px: float = 320.0
    """Focal length in columns."""
    s_v_px: float = 320.0
    """Focal length in rows."""
    u0_px: float = 320.0
    v0_px: float = 240.0
    width_px: int = 640
    height_px: int = 480

    def __post_init__(self) -> None:
        require_positive(self, "s_u_px", "s_v_px", "width_px", "height_px")

    def project(self, points_c: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., 2) pixels of (..., 3) points of its frame.  Source: [Wu2022] Eqs. 3, 26."""
        return project(np.asarray(points_c, float), self.K)

    def rays(self, pixels: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., 3) unit vectors in the camera's frame towards (..., 2) pixels.

        Source: [Wu2022] Eq. 11, normalised: its Eq. 13 takes the arcsine of a component.
        """
        ray = rays_of(np.asarray(pixels, float), self.K)
        return ray / np.linalg.norm(ray, axis=-1, keepdims=True)

    def rays_body(self, pixels: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., 3) unit vectors in the body's frame.  Source: [Wu2022] Eq. 12."""
        return self.rays(pixels) @ R_BODY_CAMERA.T

    def contains(self, pixels: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which of (..., 2) pixels are inside the image."""
        pixels = np.asarray(pixels, float)
        size = np.array([self.width_px, self.height_px])
        return np.all((pixels >= 0.0) & (pixels < size), axis=-1)

    @cached_property
    def intrinsics_px(self) -> NDArray[np.float64]:
        """(4,): s_u, s_v, u0, v0."""
        return np.array([self.s_u_px, self.s_v_px, self.u0_px, self.v0_px], float)

    @cached_property
    def K(self) -> NDArray[np.float64]:
        """(3, 3) intrinsics."""
        s_u, s_v, u0, v0 = self.intrinsics_px
        return np.array([[s_u, 0.0, u0], [0.0, s_v, v0], [0.0, 0.0, 1.0]])


def _finite(name: str, values: ArrayLike, width: int) -> NDArray[np.float64]:
    """A read-only copy of (..., width) finite numbers; ValueError names what is wrong."""
    array = np.array(values, float)
    if array.shape[-1:] != (width,):
        raise ValueError(f"{name} must have {width} numbers on its last axis, got {array.shape}")
    if not np.isfinite(array).all():
        bad = array.reshape(-1)[~np.isfinite(array.reshape(-1))][0]
        raise ValueError(f"{name} must be finite numbers, got {bad}")
    array.setflags(write=False)
    return array


@dataclass(frozen=True, eq=False)
class BodyIncrement:
    """A motion in the frame of the body as it was before: first the displacement, then the turn."""

    displacement_m: NDArray[np.float64]
    """(..., 3): forward, left, up."""
    rotation_rad: NDArray[np.float64]
    """(..., 3): roll, pitch, yaw increments about the body's axes."""

    def __post_init__(self) -> None:
        for name in ("displacement_m", "rotation_rad"):
            object.__setattr__(self, name, _finite(name, getattr(self, name), 3))

    @classmethod
    def none(cls) -> Self:
        """No motion: the odometry of the first iteration."""
        return cls(np.zeros(3), np.zeros(3))


@dataclass(frozen=True, eq=False)
class FeatureObservation:
    """Landmarks that the camera sees: who they are and where in the image."""

    ids: NDArray[np.int64]
    """(n,): an id is the same landmark in every image, and a new landmark has a new id."""
    pixels: NDArray[np.float64]
    """(n, 2): column and row."""

    def __post_init__(self) -> None:
        ids = np.array(self.ids, np.int64).reshape(-1)
        pixels = _finite("pixels", np.reshape(self.pixels, (-1, 2)), 2)
        if len(ids) != len(pixels):
            raise ValueError(f"ids and pixels must be as many, got {len(ids)} and {len(pixels)}")
        if len(np.unique(ids)) != len(ids):
            values, counts = np.unique(ids, return_counts=True)
            raise ValueError(f"ids must differ, got {values[counts > 1][0]} twice")
        ids.setflags(write=False)
        object.__setattr__(self, "ids", ids)
        object.__setattr__(self, "pixels", pixels)

    @classmethod
    def none(cls) -> Self:
        """No landmark in view."""
        return cls(np.empty(0, np.int64), np.empty((0, 2)))


@dataclass(frozen=True, eq=False)
class Measurements:
    """All that one iteration has: no truth among it. Non-finite numbers raise ValueError."""

    odometry: BodyIncrement
    features: FeatureObservation = field(default_factory=FeatureObservation.none)
    target_px: NDArray[np.float64] | None = None
    """(2,): column and row of the target; None where it is not seen."""
    is_target_seen: NDArray[np.bool_] | None = None
    """(...,): for several runs at once, in which of them `target_px` counts; all if None."""

    def __post_init__(self) -> None:
        if self.target_px is not None:
            object.__setattr__(self, "target_px", _finite("target_px", self.target_px, 2))


@dataclass(frozen=True, eq=False)
class MotionCommand:
    """What the vehicle shall do in the next time step, and of what it is made."""

    increment: BodyIncrement
    """The motion: of length v_max dt or less, and the turn that looks at the target."""
    follow_mps: NDArray[np.float64]
    """(...,): the following part, along the body's x axis; negative to back off."""
    observability_mps: NDArray[np.float64]
    """(..., 3): the part that makes the range observable, in the body's frame."""


@dataclass(frozen=True, eq=False)
class PoseBelief:
    """Where the vehicle takes itself to be."""

    position_m: NDArray[np.float64]
    """(..., 3): in the world."""
    R_world_body: NDArray[np.float64]
    """(..., 3, 3): orientation of the body in the world."""
    covariance: NDArray[np.float64]
    """(..., 6, 6) of the errors: position in the world [m], rotation vector in the body [rad]."""


@dataclass(frozen=True, eq=False)
class TargetBelief:
    """Where the target is taken to be, and how it moves."""

    position_m: NDArray[np.float64]
    """(..., 3): in the world."""
    velocity_mps: NDArray[np.float64]
    """(..., 3): in the world."""
    covariance: NDArray[np.float64]
    """(..., 6, 6) of position and velocity."""
