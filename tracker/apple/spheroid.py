"""The fruit as a spheroid, and what a camera sees: its outline, an exact conic, and its calyx.

Seen from the point p, the rays d that touch a spheroid with centre c, equatorial radius r, aspect k
and axis a form a cone. With y = c - p, g = 1/k² - 1 and B = I + g a aᵀ (so that the surface is
(x - c)ᵀ B (x - c) = r²) the rays of the cone are those with

    q(d) = (dᵀBy)² - (yᵀBy - r²) dᵀBd = 0,

the dual form of [Hartley2004] Result 8.9 written out with rays in place of pixels; q is above zero
inside the outline. Vectors are in the robot's frame.
"""

import math
from dataclasses import dataclass

import numpy as np

from tracker.apple.view import CameraPose
from tracker.checks import require_positive
from tracker.geometry import project


@dataclass(frozen=True, eq=False)
class Spheroid:
    """A fruit: an ellipsoid of revolution with its stem at one pole and its calyx at the other."""

    centre_m: np.ndarray
    """(3,) in the robot's frame."""
    axis: np.ndarray
    """(3,) unit vector from the calyx to the stem."""
    radius_m: float
    """Equatorial radius."""
    aspect: float
    """Height divided by diameter; below 1 for an oblate fruit, as most apples are."""

    def __post_init__(self) -> None:
        require_positive(self, "radius_m", "aspect")
        if abs(float(np.linalg.norm(self.axis)) - 1.0) > 1e-6:
            raise ValueError(f"axis must be a unit vector, got {self.axis.tolist()}")

    @property
    def calyx_m(self) -> np.ndarray:
        """(3,) the pole with the calyx."""
        return self.centre_m - self.aspect * self.radius_m * self.axis

    def cone(self, pose: CameraPose) -> np.ndarray:
        """(3, 3) matrix C of the rays d in the camera's frame that touch: dᵀCd = 0."""
        g = 1.0 / self.aspect**2 - 1.0
        B = np.eye(3) + g * np.outer(self.axis, self.axis)
        y = self.centre_m - pose.position_m
        By = B @ y
        size = float(y @ By) - self.radius_m**2
        if size <= 0.0:
            raise ValueError("the camera is inside the fruit")
        C = np.outer(By, By) - size * B
        return pose.rotation.T @ C @ pose.rotation

    def outline_px(self, K: np.ndarray, pose: CameraPose, count: int = 64) -> np.ndarray:
        """(count, 2) pixels on the outline, at equal angles about the cone's axis."""
        directions, half_angles = principal_cone(self.cone(pose))
        turn = np.linspace(0.0, 2.0 * math.pi, count, endpoint=False)
        slopes = np.tan(half_angles)[:, None] * np.array([np.cos(turn), np.sin(turn)])
        rays = directions[2] + slopes.T @ directions[:2]
        return project(rays, K)

    def calyx_facing(self, pose: CameraPose) -> float:
        """Cosine between the calyx's outward normal and the direction to the camera.

        Above 0, nothing of the fruit itself is between the calyx and the camera.
        """
        to_camera = pose.position_m - self.calyx_m
        return float(-self.axis @ to_camera / np.linalg.norm(to_camera))

    def calyx_px(self, K: np.ndarray, pose: CameraPose) -> np.ndarray:
        """(2,) pixel of the pole with the calyx, in sight or not."""
        return project(pose.rotation.T @ (self.calyx_m - pose.position_m), K)


def cone_of_ellipse(
    centre_px: np.ndarray, semi_axes_px: np.ndarray, major_angle_rad: float, K: np.ndarray
) -> np.ndarray:
    """(3, 3) matrix of the rays through an ellipse in the image, in the camera's frame."""
    c, s = math.cos(major_angle_rad), math.sin(major_angle_rad)
    T = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    T[:2, 2] = -T[:2, :2] @ centre_px
    A = T @ K
    return A.T @ np.diag([-1.0 / semi_axes_px[0] ** 2, -1.0 / semi_axes_px[1] ** 2, 1.0]) @ A


def principal_cone(C: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Axes and half-angles of an elliptic cone dᵀCd = 0.

    Returns: (3, 3) rows: the direction across which it is widest, that across which it is
        narrowest, and its own axis, which points forward; (2,) the two half-angles [rad].
    """
    values, vectors = np.linalg.eigh(C)
    if (values > 0).sum() == 2:
        values, vectors = np.linalg.eigh(-C)
    if not (values[1] < 0.0 < values[2]):
        raise ValueError("the matrix is not that of an elliptic cone")
    # Wide is where little slope reaches the cone: the eigenvalue nearest to zero.
    directions = vectors[:, [1, 0, 2]].T
    directions[2] *= np.sign(directions[2, 2])
    return directions, np.arctan(np.sqrt(values[2] / -values[[1, 0]]))


def ellipse_of_cone(C: np.ndarray, K: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """The ellipse in which a cone of rays (3, 3) in the camera's frame meets the image.

    Returns: (2,) centre [px]; (2,) major and minor semi-axis [px]; angle of the major axis [rad]
        from +u towards +v, in [0, π). ValueError where the cone is not wholly before the camera.
    """
    inverse = np.linalg.inv(K)
    conic = inverse.T @ C @ inverse
    A, b = conic[:2, :2], conic[:2, 2]
    if not np.linalg.det(A) > 0.0:
        raise ValueError("the cone does not meet the image in an ellipse")
    centre = -np.linalg.solve(A, b)
    level = float(conic[2, 2] + b @ centre)
    values, vectors = np.linalg.eigh(-A / level)
    major = vectors[:, 0]
    angle = math.atan2(float(major[1]), float(major[0])) % math.pi
    return centre, 1.0 / np.sqrt(values), angle if angle < math.pi else 0.0
