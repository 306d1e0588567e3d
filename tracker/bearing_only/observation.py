"""The target's pixel, and how it changes with the target and with the pose of the vehicle."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracker.bearing_only.measurements import PinholeCamera, PoseBelief
from tracker.bearing_only.observation_loops import see_all


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
    pixel, by_target, by_turn, is_in_front = see_all(camera.intrinsics_px, R.reshape(-1, 3, 3), v)
    return TargetView(
        pixel.reshape(*leading, 2),
        by_target.reshape(*leading, 2, 3),
        np.concatenate([-by_target, by_turn], axis=-1).reshape(*leading, 2, 6),
        is_in_front.reshape(leading),
    )
