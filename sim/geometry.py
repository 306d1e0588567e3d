"""Poses, rotations and pinhole projection, once for every scene.

A camera's axes are x right, y down and z forward (OpenCV) unless said otherwise; a pixel's centre
lies at integer coordinates.
"""

import math

import mujoco
import numpy as np
from numpy.typing import ArrayLike

R_BODY_CAMERA = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""Columns: axes of a camera that looks along a vehicle's x axis, in the vehicle (y left, z up)."""
R_BODY_CAMERA.flags.writeable = False

MUJOCO_AXES = np.array([1.0, -1.0, -1.0])
"""Signs that turn camera axes into MuJoCo's (x right, y up, z backward), and back."""
MUJOCO_AXES.flags.writeable = False

MUJOCO_QUAT = (0.0, 1.0, 0.0, 0.0)
"""The same as a quaternion: half a turn about x."""


def transform(rotation: ArrayLike, position_m: ArrayLike) -> np.ndarray:
    """Returns the (4, 4) pose of a rotation, (3, 3) or its 9 numbers, and a position (3,)."""
    T = np.eye(4)
    T[:3, :3] = np.reshape(rotation, (3, 3))
    T[:3, 3] = position_m
    return T


def look_at(eye_m: ArrayLike, point_m: ArrayLike, up: ArrayLike = (0.0, 0.0, 1.0)) -> np.ndarray:
    """Returns the (4, 4) pose of a camera that looks at a point, `up` pointing up in its image."""
    z = np.subtract(point_m, eye_m)
    z = z / np.linalg.norm(z)
    x = np.cross(z, np.asarray(up, float))
    if not np.linalg.norm(x) > 1e-9:
        raise ValueError(f"a camera that looks along {up} has no upright image: {eye_m}")
    x = x / np.linalg.norm(x)
    return transform(np.column_stack([x, np.cross(z, x), z]), eye_m)


def intrinsics(width_px: int, height_px: int, fovy_rad: float) -> np.ndarray:
    """Returns the (3, 3) matrix K of an image with the given vertical angle of view."""
    focal_px = 0.5 * height_px / math.tan(0.5 * fovy_rad)
    return np.array(
        [
            [focal_px, 0.0, 0.5 * (width_px - 1)],
            [0.0, focal_px, 0.5 * (height_px - 1)],
            [0.0, 0.0, 1.0],
        ]
    )


def fovy_deg(height_px: int, focal_px: float) -> float:
    """Returns the vertical angle of view of an image with that focal length, for MuJoCo."""
    return 2.0 * math.degrees(math.atan(0.5 * height_px / focal_px))


def project(P: np.ndarray, points_m: np.ndarray) -> np.ndarray:
    """Returns the (n, 2) pixels of points (n, 3) under a projection matrix (3, 4)."""
    uvw = points_m @ P[:, :3].T + P[:, 3]
    return uvw[:, :2] / uvw[:, 2:]


def quaternion(rotation: np.ndarray) -> np.ndarray:
    """Returns the (4,) quaternion wxyz of a rotation (3, 3)."""
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, rotation.ravel())
    return quat


def yaw_quaternion(yaw_rad: float) -> tuple[float, float, float, float]:
    """Returns the quaternion wxyz of a turn about z."""
    return math.cos(0.5 * yaw_rad), 0.0, 0.0, math.sin(0.5 * yaw_rad)


def rotation(roll_rad: float, yaw_rad: float, pitch_rad: float) -> np.ndarray:
    """Returns the (3, 3) rotation: pitch about x, then yaw about y, then roll about z.

    SciPy's goes by way of a quaternion, and the last digits of the published films would differ.
    """
    cx, cy, cz = (math.cos(angle) for angle in (pitch_rad, yaw_rad, roll_rad))
    sx, sy, sz = (math.sin(angle) for angle in (pitch_rad, yaw_rad, roll_rad))
    pitch = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    yaw = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    roll = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return roll @ yaw @ pitch
