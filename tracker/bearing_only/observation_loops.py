"""Compiled: points in the camera, and the derivatives of their pixels."""

import numpy as np
from numba import njit

from tracker.bearing_only.small_matrices import dot
from tracker.geometry import R_BODY_CAMERA

LEAST_DEPTH_M = 1e-3
"""Points nearer to the image plane, or behind it, have no pixel."""


@njit(cache=True, error_model="numpy")
def see_all(
    intrinsics_px: np.ndarray, R_world_body: np.ndarray, v: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Pixels (n, 2), derivatives (n, 2, 3) by v (n, 3) and by the turn, and which are in front.

    As `see`, with a rotation (n, 3, 3) for each.
    """
    n = len(v)
    pixels, is_in_front = np.empty((n, 2)), np.empty(n, np.bool_)
    by_v, by_turn = np.empty((n, 2, 3)), np.empty((n, 2, 3))
    for i in range(n):
        is_in_front[i] = see(intrinsics_px, R_world_body[i], v[i], pixels[i], by_v[i], by_turn[i])
    return pixels, by_v, by_turn, is_in_front


@njit(cache=True, error_model="numpy")
def see(
    intrinsics_px: np.ndarray,
    R_world_body: np.ndarray,
    v: np.ndarray,
    pixel: np.ndarray,
    by_v: np.ndarray,
    by_turn: np.ndarray,
) -> bool:
    """Whether a point at v (3,) from the camera, in the world, is in front.

    Args:
        intrinsics_px: (4,) s_u, s_v, u0, v0.
        R_world_body: (3, 3).
        v: (3,); only its direction counts for the pixel.
        pixel: (2,) filled; that of a point straight ahead where none is.
        by_v: (2, 3) filled: derivatives of the pixel by v. By the point in the camera's frame they
            are H1 / z of [Wu2022] Eq. 29.
        by_turn: (2, 3) filled: by a turn of the body, a rotation vector in its frame.
    """
    b = (dot(R_world_body[:, 0], v), dot(R_world_body[:, 1], v), dot(R_world_body[:, 2], v))
    c = (dot(R_BODY_CAMERA[:, 0], b), dot(R_BODY_CAMERA[:, 1], b), dot(R_BODY_CAMERA[:, 2], b))
    is_in_front = c[2] > LEAST_DEPTH_M
    if not is_in_front:
        c = (0.0, 0.0, 1.0)
    for a in range(2):
        scale = intrinsics_px[a] / c[2]
        pixel[a] = intrinsics_px[2 + a] + scale * c[a]
        by_c = (scale if a == 0 else 0.0, scale if a == 1 else 0.0, -scale * c[a] / c[2])
        by_b = (
            dot(R_BODY_CAMERA[0], by_c),
            dot(R_BODY_CAMERA[1], by_c),
            dot(R_BODY_CAMERA[2], by_c),
        )
        for k in range(3):
            by_v[a, k] = dot(R_world_body[k], by_b)
        by_turn[a, 0] = by_b[1] * b[2] - by_b[2] * b[1]
        by_turn[a, 1] = by_b[2] * b[0] - by_b[0] * b[2]
        by_turn[a, 2] = by_b[0] * b[1] - by_b[1] * b[0]
    return is_in_front
