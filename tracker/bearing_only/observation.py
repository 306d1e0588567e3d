"""The target's pixel, and how it changes with the target and with the pose of the vehicle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracker.bearing_only.frames import R_BODY_CAMERA, camera_rotation, skew
from tracker.bearing_only.measurements import PinholeCamera, PoseBelief

LEAST_DEPTH_M = 1e-3
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
    """(...,)."""


def view_target(
    camera: PinholeCamera, pose: PoseBelief, target_m: NDArray[np.float64]
) -> TargetView:
    """The view of a target at (..., 3) in the world.

    Source: [Wu2022] Eqs. 3, 6 and 24 to 29 without displacement, f = 1. Its Eq. 28 differentiates
    by the vehicle's displacement, hence the minus there. Camera mount, intrinsics and distortion
    are exact here, so that their terms of Eq. 7 are zero.
    """
    R_camera_world = camera_rotation(pose.R_world_body)
    offset = target_m - pose.position_m
    b = np.einsum("...ji,...j->...i", pose.R_world_body, offset)
    c = b @ R_BODY_CAMERA
    is_in_front = c[..., 2] > LEAST_DEPTH_M
    c = np.where(is_in_front[..., None], c, [0.0, 0.0, 1.0])
    by_camera_point = pixel_jacobian(camera, c)
    by_target = by_camera_point @ R_camera_world
    by_turn = by_camera_point @ (R_BODY_CAMERA.T @ skew(b))
    by_pose = np.concatenate([-by_target, by_turn], axis=-1)
    return TargetView(camera.project(c), by_target, by_pose, is_in_front)


def pixel_jacobian(camera: PinholeCamera, c: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., 2, 3) derivative of the pixel by the (..., 3) point in the camera's frame.

    This is H1 / z of [Wu2022] Eq. 29.
    """
    x, y, z = np.moveaxis(c, -1, 0)
    J = np.zeros((*z.shape, 2, 3))
    J[..., 0, 0], J[..., 0, 2] = camera.s_u_px / z, -camera.s_u_px * x / z**2
    J[..., 1, 1], J[..., 1, 2] = camera.s_v_px / z, -camera.s_v_px * y / z**2
    return J
