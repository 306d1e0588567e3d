"""Landmarks by inverse depth and by coordinates: pixels, Jacobians, birth and conversion.

A new landmark has six numbers [Civera2008]: where the camera was when it first saw it (3), azimuth
and elevation of the ray in the world, and the inverse of the depth along it. One whose depth is
well known has three: its coordinates. All functions work on many landmarks at once.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tracker.bearing_only.frames import R_BODY_CAMERA, skew
from tracker.bearing_only.measurements import PinholeCamera, PoseBelief
from tracker.bearing_only.observation import LEAST_DEPTH_M, pixel_jacobian

Array = NDArray[np.float64]


def ray_of_angles(angles_rad: Array) -> Array:
    """(n, 3) unit vectors in the world of (n, 2) azimuths and elevations."""
    azimuth, elevation = angles_rad.T
    c = np.cos(elevation)
    return np.stack([c * np.cos(azimuth), c * np.sin(azimuth), np.sin(elevation)], axis=-1)


def ray_jacobian(angles_rad: Array) -> Array:
    """(n, 3, 2) derivatives of `ray_of_angles`."""
    azimuth, elevation = angles_rad.T
    ca, sa, ce, se = np.cos(azimuth), np.sin(azimuth), np.cos(elevation), np.sin(elevation)
    J = np.empty((len(angles_rad), 3, 2))
    J[:, 0, 0], J[:, 1, 0], J[:, 2, 0] = -ce * sa, ce * ca, 0.0
    J[:, 0, 1], J[:, 1, 1], J[:, 2, 1] = -se * ca, -se * sa, ce
    return J


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


def view_inverse_depth(
    camera: PinholeCamera, pose: PoseBelief, features: Array
) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """Pixels (n, 2), Jacobians (n, 2, 6) by pose and by feature, and which are in front.

    The point is taken times its inverse depth, so that one at infinity has a pixel as well.
    Source: [Civera2008] Eqs. 10 to 13, with an error state of the pose.
    """
    anchor, angles, rho = features[:, :3], features[:, 3:5], features[:, 5:]
    offset = anchor - pose.position_m
    v = rho * offset + ray_of_angles(angles)
    by_v, by_turn, pixels, is_in_front = _view(camera, pose, v)
    by_pose = np.concatenate([-rho[:, :, None] * by_v, by_turn], axis=2)
    by_feature = np.concatenate(
        [rho[:, :, None] * by_v, by_v @ ray_jacobian(angles), by_v @ offset[:, :, None]], axis=2
    )
    return pixels, by_pose, by_feature, is_in_front


def view_points(
    camera: PinholeCamera, pose: PoseBelief, points_m: Array
) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """Pixels (n, 2), Jacobians (n, 2, 6) by pose and (n, 2, 3) by point, and which are in front."""
    by_v, by_turn, pixels, is_in_front = _view(camera, pose, points_m - pose.position_m)
    return pixels, np.concatenate([-by_v, by_turn], axis=2), by_v, is_in_front


def _view(
    camera: PinholeCamera, pose: PoseBelief, v: Array
) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """Jacobians by the vector v in the world and by the turn, pixels, and which are in front."""
    b = v @ pose.R_world_body
    c = b @ R_BODY_CAMERA
    is_in_front = c[:, 2] > LEAST_DEPTH_M
    c = np.where(is_in_front[:, None], c, [0.0, 0.0, 1.0])
    by_body = pixel_jacobian(camera, c) @ R_BODY_CAMERA.T
    return by_body @ pose.R_world_body.T, by_body @ skew(b), camera.project(c), is_in_front


def new_features(
    camera: PinholeCamera, pose: PoseBelief, pixels: Array, rho_per_m: float
) -> tuple[Array, Array, Array]:
    """(n, 6) features on the rays of their first pixels, and what they depend on.

    Source: [Civera2008] section III-C.
    Returns: features, Jacobians (n, 6, 6) by the error state of the pose and (n, 2, 2) of azimuth
    and elevation by the pixel.
    """
    xy = (pixels - [camera.u0_px, camera.v0_px]) / [camera.s_u_px, camera.s_v_px]
    body = np.concatenate([xy, np.ones((len(xy), 1))], axis=1) @ R_BODY_CAMERA.T
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
    angles, rho = features[:, 3:5], features[:, 5:]
    ray = ray_of_angles(angles)
    J = np.empty((len(features), 3, 6))
    J[:, :, :3] = np.eye(3)
    J[:, :, 3:5] = ray_jacobian(angles) / rho[:, :, None]
    J[:, :, 5] = -ray / rho**2
    return features[:, :3] + ray / rho, J


def linearity(features: Array, rho_variance: Array, position_m: Array) -> Array:
    """(n,): how nonlinear the coordinates would be; 0.1 and less is linear enough.

    Source: [Civera2008] Eq. 38: 4 sigma_d / d1 |cos alpha|, with the depth's standard deviation
    sigma_d, the distance d1 from the camera now, and the parallax alpha.
    """
    rho = features[:, 5]
    ray = ray_of_angles(features[:, 3:5])
    with np.errstate(divide="ignore", invalid="ignore"):
        now = features[:, :3] + ray / rho[:, None] - position_m
        d1 = np.linalg.norm(now, axis=1)
        cosine = np.abs(np.einsum("ij,ij->i", ray, now)) / d1
        index = 4.0 * np.sqrt(rho_variance) / rho**2 / d1 * cosine
    return np.where(np.isfinite(index) & (rho > 0.0), index, np.inf)
