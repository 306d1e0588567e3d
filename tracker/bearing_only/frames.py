"""Frames and rotations.

World; body: x forward, y left, z up; camera: x right, y down, z forward.

A rotation `R_a_b` takes vectors of frame b into frame a. Every function broadcasts over leading
axes. [Wu2022] calls R(q) "world to robot" in Eq. 2 and multiplies body increments by it, so it is
`R_world_body`; its Eqs. 25 to 36 need z along the optical axis, so R^(W->R) there is
`R_camera_world`, while x is forward in its Eqs. 13 and 15.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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
    phi = np.asarray(phi_rad, float)
    square = np.einsum("...i,...i->...", phi, phi)[..., None, None]
    angle = np.sqrt(square)
    is_small = angle < 1e-6
    safe = np.where(is_small, 1.0, angle)
    a = np.where(is_small, 1.0 - square / 6.0, np.sin(safe) / safe)
    b = np.where(is_small, 0.5 - square / 24.0, (1.0 - np.cos(safe)) / safe**2)
    K = skew(phi)
    return np.eye(3) + a * K + b * (K @ K)


def rotation_of_euler(phi_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., 3, 3) rotations Rz(yaw) Ry(pitch) Rx(roll) of (..., 3) angles roll, pitch, yaw.

    [Wu2022] Eq. 2 adds half of Omega(dphi) q to the quaternion: a multiplication from the right, so
    the angles are increments about the body's axes, but correct to first order only and without
    the normalisation that it needs. This is exact.
    """
    phi = np.asarray(phi_rad, float)
    (sr, sp, sy), (cr, cp, cy) = (np.moveaxis(f(phi), -1, 0) for f in (np.sin, np.cos))
    rows = (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def camera_rotation(R_world_body: NDArray[np.float64]) -> NDArray[np.float64]:
    """`R_camera_world` of a camera that looks along the body's x axis."""
    return R_BODY_CAMERA.T @ np.swapaxes(R_world_body, -1, -2)
