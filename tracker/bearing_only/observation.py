"""The target's pixel, and how it changes with the target and with the pose of the vehicle."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tracker.bearing_only.measurements import PinholeCamera, PoseBelief
from tracker.bearing_only.small_matrices import dot
from tracker.geometry import R_BODY_CAMERA

_LEAST_DEPTH_M = 1e-3
"""Points nearer to the image plane, or behind it, have no pixel."""


@dataclass(frozen=True, eq=False)
class TargetView:
    """Where the target should appear, and the Jacobians of its pixel."""

    pixel: NDArray[np.float64]
    """(..., 2); meaningless where the target is not in front."""
    by_target: NDArray[np.float64]
    """(..., 2, 3): by the target's position in the world; H^(t->z) of [Wu2022] Eq. 7."""
    by_pose: NDArray[np.float64]
    """(..., 2, 6): by the error state of the pose; H^(r->z) of [Wu2022] Eq. 7."""
    is_in_front: NDArray[np.bool_]
    """(...,): whether the target is in front of the camera."""


def view_target(
    camera: PinholeCamera, pose: PoseBelief, target_m: NDArray[np.float64]
) -> TargetView:
    """The view of a target at (..., 3) in the world.

    Source: [Wu2022] Eqs. 3, 6 and 24 to 29 without displacement, f = 1. Its Eq. 28 differentiates
    by the vehicle's displacement, hence the minus there. Camera mount, intrinsics and distortion
    are exact here, so that their terms of Eq. 7 are zero. One that is not in front has the
    Jacobians of a point straight ahead.
    """
    leading = target_m.shape[:-1]
    R = pose.R_world_body
    if R.shape[:-2] != leading:
        R = np.broadcast_to(R, (*leading, 3, 3))
    v = (target_m - pose.position_m).reshape(-1, 3)
    pixel, by_target, by_turn, is_in_front = _see_all(camera.intrinsics_px, R.reshape(-1, 3, 3), v)
    return TargetView(
        pixel.reshape(*leading, 2),
        by_target.reshape(*leading, 2, 3),
        np.concatenate([-by_target, by_turn], axis=-1).reshape(*leading, 2, 6),
        is_in_front.reshape(leading),
    )


@njit(cache=True, error_model="numpy")
def _see_all(
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
    is_in_front = c[2] > _LEAST_DEPTH_M
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
