"""The apple as a solid: an oblate spheroid, and where its outline and its calyx are in an image.

Fruit frame: origin at the centre, z along the fruit axis from the calyx to the stem.
"""

from dataclasses import dataclass

import numpy as np

from sim.checks import require_positive, require_within

CALYX_DEPTH_M = 0.0009
CALYX_HALF_THICKNESS_M = 0.0015
"""The calyx is a lens sunk so deep below the pole: it stands out by 0.6 mm."""


@dataclass(frozen=True)
class Fruit:
    """The shape of an apple."""

    radius_m: float = 0.040
    """Equatorial radius."""
    aspect: float = 0.90
    """Height over diameter; below 1 for an oblate fruit."""
    calyx_radius_m: float = 0.009
    stem_length_m: float = 0.018
    stem_radius_m: float = 0.0016

    def __post_init__(self) -> None:
        require_positive(self, *self.__dataclass_fields__)
        require_within(self, 0.5, 1.5, "aspect")

    @property
    def half_height_m(self) -> float:
        """Distance from the centre to either pole."""
        return self.aspect * self.radius_m


@dataclass(frozen=True, eq=False)
class PlacedFruit:
    """An apple with its pose in the world."""

    fruit: Fruit
    centre_m: np.ndarray
    """(3,) centre of the spheroid in the world."""
    axis: np.ndarray
    """(3,) unit vector in the world, from the calyx to the stem."""

    def __post_init__(self) -> None:
        if self.centre_m.shape != (3,) or not np.isfinite(self.centre_m).all():
            raise ValueError(f"centre_m must be 3 finite numbers, got {self.centre_m!r}")
        if self.axis.shape != (3,) or not abs(float(np.linalg.norm(self.axis)) - 1.0) < 1e-6:
            raise ValueError(f"axis must be a unit vector of 3 numbers, got {self.axis!r}")
        self.centre_m.setflags(write=False)
        self.axis.setflags(write=False)

    @property
    def rotation(self) -> np.ndarray:
        """(3, 3) fruit -> world; a spheroid leaves the turn about its axis open."""
        helper = np.eye(3)[np.argmin(np.abs(self.axis))]
        x = np.cross(helper, self.axis)
        x /= np.linalg.norm(x)
        return np.column_stack([x, np.cross(self.axis, x), self.axis])

    @property
    def calyx_m(self) -> np.ndarray:
        """(3,) pole of the spheroid on the side of the calyx, in the world."""
        return self.centre_m - self.fruit.half_height_m * self.axis

    def outline_px(self, K: np.ndarray, T_world_camera: np.ndarray, count: int) -> np.ndarray:
        """(count, 2) pixels of the outline, evenly spaced in the angle about its middle.

        A ray from the camera touches the spheroid `x' A x = 1` where its discriminant vanishes:
        with e the camera in the fruit's frame, `v' (A e e' A - (e' A e - 1) A) v = 0`, a conic.

        Args:
            K: (3, 3) intrinsics.
            T_world_camera: (4, 4) pose of the camera, x right, y down, z forward.
            count: How many points.
        """
        conic = self.outline_conic(K, T_world_camera)
        middle = -np.linalg.solve(conic[:2, :2], conic[:2, 2])
        angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
        direction = np.column_stack([np.cos(angle), np.sin(angle)])
        curvature = np.einsum("ni,ij,nj->n", direction, conic[:2, :2], direction)
        level = conic[2, 2] + middle @ conic[:2, 2]
        return middle + direction * np.sqrt(-level / curvature)[:, None]

    def outline_conic(self, K: np.ndarray, T_world_camera: np.ndarray) -> np.ndarray:
        """(3, 3) symmetric C with `p' C p = 0` for the homogeneous pixels p of the outline."""
        k, axis = self.fruit.aspect, self.axis
        A = (np.eye(3) + (1.0 / k**2 - 1.0) * np.outer(axis, axis)) / self.fruit.radius_m**2
        e = T_world_camera[:3, 3] - self.centre_m
        Ae = A @ e
        cone = np.outer(Ae, Ae) - (e @ Ae - 1.0) * A
        to_ray = T_world_camera[:3, :3] @ np.linalg.inv(K)
        conic = to_ray.T @ cone @ to_ray
        return conic / np.trace(conic[:2, :2])
