"""Rotations, and the pinhole camera without distortion.

Frames: the camera has x right, y down and z forward (OpenCV); a body has x forward, y left and z
up. A rotation `R_a_b` takes vectors of frame b into frame a. Every function broadcasts over leading
axes. [Wu2022] calls R(q) "world to robot" in Eq. 2 and multiplies body increments by it, so it is
`R_world_body`; its Eqs. 25 to 36 need z along the optical axis, so R^(W->R) there is
`R_camera_world`, while x is forward in its Eqs. 13 and 15.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

R_BODY_CAMERA = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""Columns: the camera's axes in the body; R^(C->R) of [Wu2022] Eq. 12."""
R_BODY_CAMERA.setflags(write=False)


def skew(v: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., 3, 3) matrices with `skew(a) @ b = a x b` of (..., 3) vectors."""
    v = np.asarray(v, float)
    matrix = np.zeros((*v.shape, 3))
    matrix[..., 0, 1], matrix[..., 0, 2], matrix[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    matrix[..., 1, 0], matrix[..., 2, 0], matrix[..., 2, 1] = v[..., 2], -v[..., 1], v[..., 0]
    return matrix


def rotation_of_vector(phi_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., 3, 3) rotations about (..., 3) axes by the vectors' lengths (Rodrigues' formula)."""
    phi = np.ascontiguousarray(phi_rad, float)
    return _of_vectors(phi.reshape(-1, 3)).reshape(*phi.shape, 3)


def rotation_of_euler(phi_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., 3, 3) rotations Rz(yaw) Ry(pitch) Rx(roll) of (..., 3) angles roll, pitch, yaw.

    [Wu2022] Eq. 2 adds half of Omega(dphi) q to the quaternion: a multiplication from the right, so
    the angles are increments about the body's axes, but correct to first order only and without
    the normalisation that it needs. This is exact.
    """
    phi = np.ascontiguousarray(phi_rad, float)
    return _of_eulers(phi.reshape(-1, 3)).reshape(*phi.shape, 3)


def rotation_about_fixed_axes(order: str, angles_deg: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 3, 3) rotations by turns about the fixed axes x, y and z, taken in an order like `"xyz"`.

    `angles_deg` (n, 3) are those about x, y and z, whatever the order.
    """
    in_order = angles_deg[..., ["xyz".index(axis) for axis in order]]
    return Rotation.from_euler(order, in_order, degrees=True).as_matrix()


def least_rotation(start: NDArray[np.float64], end: NDArray[np.float64]) -> NDArray[np.float64]:
    """(3, 3) rotation by the least angle that takes the direction of `start` (3,) to `end` (3,)."""
    return Rotation.align_vectors(end[None], start[None])[0].as_matrix()


def project(points: NDArray[np.float64], K: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., 2) pixels of points (..., 3) in the frame of the camera with intrinsics K (3, 3)."""
    return K[:2, 2] + K.diagonal()[:2] * points[..., :2] / points[..., 2:]


def rays_of(pixels: NDArray[np.float64], K: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., 3) rays through pixels (..., 2) in the camera's frame, with z = 1."""
    xy = (pixels - K[:2, 2]) / K.diagonal()[:2]
    return np.concatenate([xy, np.ones((*xy.shape[:-1], 1))], axis=-1)


def camera_rotation(R_world_body: NDArray[np.float64]) -> NDArray[np.float64]:
    """`R_camera_world` of a camera that looks along the body's x axis."""
    return R_BODY_CAMERA.T @ np.swapaxes(R_world_body, -1, -2)


@njit(cache=True, error_model="numpy")
def _of_vectors(phi: np.ndarray) -> np.ndarray:
    R = np.empty((len(phi), 3, 3))
    for i in range(len(phi)):
        x, y, z = phi[i]
        square = x * x + y * y + z * z
        a, b = 1.0 - square / 6.0, 0.5 - square / 24.0
        if square > 1e-12:
            angle = math.sqrt(square)
            a, b = math.sin(angle) / angle, (1.0 - math.cos(angle)) / square
        R[i, 0] = 1.0 - b * (y * y + z * z), b * x * y - a * z, b * x * z + a * y
        R[i, 1] = b * x * y + a * z, 1.0 - b * (x * x + z * z), b * y * z - a * x
        R[i, 2] = b * x * z - a * y, b * y * z + a * x, 1.0 - b * (x * x + y * y)
    return R


@njit(cache=True, error_model="numpy")
def _of_eulers(phi: np.ndarray) -> np.ndarray:
    R = np.empty((len(phi), 3, 3))
    for i in range(len(phi)):
        roll, pitch, yaw = phi[i]
        sr, sp, sy = math.sin(roll), math.sin(pitch), math.sin(yaw)
        cr, cp, cy = math.cos(roll), math.cos(pitch), math.cos(yaw)
        R[i, 0] = cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr
        R[i, 1] = sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr
        R[i, 2] = -sp, cp * sr, cp * cr
    return R
