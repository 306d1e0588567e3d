"""Landmarks by inverse depth and by coordinates: pixels, Jacobians, birth and conversion.

A new landmark has six numbers [Civera2008]: where the camera was when it first saw it (3), azimuth
and elevation of the ray in the world, and the inverse of the depth along it. One whose depth is
well known has three: its coordinates. All functions work on many landmarks at once.
"""

import numpy as np
from numpy.typing import NDArray

from tracker.bearing_only import feature_loops as loops
from tracker.bearing_only.measurements import PinholeCamera, PoseBelief
from tracker.geometry import R_BODY_CAMERA, rays_of, skew

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def angles_of_ray(rays: Array) -> Array:
    """(n, 2) azimuths and elevations of (n, 3) vectors of any length."""
    horizontal = np.hypot(rays[:, 0], rays[:, 1])
    return np.stack(
        [np.arctan2(rays[:, 1], rays[:, 0]), np.arctan2(rays[:, 2], horizontal)], axis=-1
    )


def angles_jacobian(rays: Array) -> Array:
    """(n, 2, 3) derivatives of `angles_of_ray`."""
    x, y, z = rays.T
    square = x**2 + y**2
    horizontal, length2 = np.sqrt(square), square + z**2
    J = np.zeros((len(rays), 2, 3))
    J[:, 0, 0], J[:, 0, 1] = -y / square, x / square
    J[:, 1, 0] = -x * z / (horizontal * length2)
    J[:, 1, 1] = -y * z / (horizontal * length2)
    J[:, 1, 2] = horizontal / length2
    return J


def view_landmarks(
    camera: PinholeCamera, pose: PoseBelief, x: Array, places: Index, sizes: Index
) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """Pixels (n, 2), Jacobians (n, 2, 6) by pose and by landmark, and which are in front.

    A landmark's numbers are x[place : place + size]; the derivatives by one with three of them are
    followed by zeros. One by inverse depth is taken times it, so that it has a pixel at infinity
    as well. Source: [Civera2008] Eqs. 10 to 13, with an error state of the pose.
    """
    return loops.view(camera.intrinsics_px, pose.position_m, pose.R_world_body, x, places, sizes)


def new_features(
    camera: PinholeCamera, pose: PoseBelief, pixels: Array, rho_per_m: float
) -> tuple[Array, Array, Array]:
    """(n, 6) features on the rays of their first pixels, and what they depend on.

    Source: [Civera2008] section III-C.
    Returns: features, Jacobians (n, 6, 6) by the error state of the pose and (n, 2, 2) of azimuth
    and elevation by the pixel.
    """
    body = rays_of(pixels, camera.K) @ R_BODY_CAMERA.T
    rays = body @ pose.R_world_body.T
    n = len(pixels)
    features = np.empty((n, 6))
    features[:, :3], features[:, 3:5] = pose.position_m, angles_of_ray(rays)
    features[:, 5] = rho_per_m
    by_ray = angles_jacobian(rays)
    by_pose = np.zeros((n, 6, 6))
    by_pose[:, :3, :3] = np.eye(3)
    by_pose[:, 3:5, 3:] = -by_ray @ pose.R_world_body @ skew(body)
    by_xy = pose.R_world_body @ R_BODY_CAMERA[:, :2]
    by_pixel = by_ray @ by_xy / np.array([camera.s_u_px, camera.s_v_px])
    return features, by_pose, by_pixel


def points_of(features: Array) -> tuple[Array, Array]:
    """(n, 3) coordinates of (n, 6) features, and their (n, 3, 6) Jacobians.

    Source: [Civera2008] Eq. 3.
    """
    return loops.points_of(features)


def linearity(features: Array, rho_variance: Array, position_m: Array) -> Array:
    """(n,): how nonlinear the coordinates would be; 0.1 and less is linear enough.

    Source: [Civera2008] Eq. 38: 4 sigma_d / d1 |cos alpha|, with the depth's standard deviation
    sigma_d, the distance d1 from the camera now, and the parallax alpha.
    """
    return loops.linearity(features, rho_variance, position_m)
