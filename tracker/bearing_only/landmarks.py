"""Landmarks by inverse depth and by coordinates: table, pixels, Jacobians, birth and conversion.

A new landmark has six numbers [Civera2008]: where the camera was when it first saw it (3), azimuth
and elevation of the ray in the world, and the inverse of the depth along it. One whose depth is
well known has three: its coordinates. All functions work on many landmarks at once.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tracker.bearing_only.measurements import PinholeCamera, PoseBelief
from tracker.bearing_only.observation import see
from tracker.bearing_only.small_matrices import dot
from tracker.geometry import R_BODY_CAMERA, rays_of, skew

POSE = 6
"""Numbers of the pose, the first of the state."""
INVERSE_DEPTH, COORDINATES = 6, 3
"""Numbers of a landmark in the state."""

Array = NDArray[np.float64]
_NO_RAY = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


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


@njit(cache=True, error_model="numpy")
def view_landmarks(
    intrinsics_px: np.ndarray,
    position_m: np.ndarray,
    R_world_body: np.ndarray,
    x: np.ndarray,
    places: np.ndarray,
    sizes: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Pixels (n, 2), Jacobians (n, 2, 6) by pose and by landmark, and which are in front.

    A landmark's numbers are x[place : place + size]; the derivatives by one with three of them are
    followed by zeros. One by inverse depth is taken times it, so that it has a pixel at infinity
    as well. Source: [Civera2008] Eqs. 10 to 13, with an error state of the pose.
    """
    n = len(places)
    pixels, is_in_front = np.empty((n, 2)), np.empty(n, np.bool_)
    by_pose, by_feature = np.empty((n, 2, POSE)), np.zeros((n, 2, INVERSE_DEPTH))
    offset, v, by_v, by_turn = np.empty(3), np.empty(3), np.empty((2, 3)), np.empty((2, 3))
    for i in range(n):
        numbers, is_deep = x[places[i] :], sizes[i] == INVERSE_DEPTH
        rho = numbers[5] if is_deep else 1.0
        ray, by_azimuth, by_elevation = _ray(numbers[3], numbers[4]) if is_deep else _NO_RAY
        for k in range(3):
            offset[k] = numbers[k] - position_m[k]
            v[k] = rho * offset[k] + ray[k]
        is_in_front[i] = see(intrinsics_px, R_world_body, v, pixels[i], by_v, by_turn)
        for a in range(2):
            for k in range(3):
                by_pose[i, a, k] = -rho * by_v[a, k]
                by_pose[i, a, 3 + k] = by_turn[a, k]
                by_feature[i, a, k] = rho * by_v[a, k]
            if is_deep:
                by_feature[i, a, 3] = dot(by_v[a], by_azimuth)
                by_feature[i, a, 4] = dot(by_v[a], by_elevation)
                by_feature[i, a, 5] = dot(by_v[a], offset)
    return pixels, by_pose, by_feature, is_in_front


@njit(cache=True, error_model="numpy")
def points_of(features: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) coordinates of (n, 6) features, and their (n, 3, 6) Jacobians.

    Source: [Civera2008] Eq. 3.
    """
    n = len(features)
    points, J = np.empty((n, 3)), np.zeros((n, 3, INVERSE_DEPTH))
    for i in range(n):
        rho = features[i, 5]
        ray, by_azimuth, by_elevation = _ray(features[i, 3], features[i, 4])
        for k in range(3):
            points[i, k] = features[i, k] + ray[k] / rho
            J[i, k, k] = 1.0
            J[i, k, 3], J[i, k, 4] = by_azimuth[k] / rho, by_elevation[k] / rho
            J[i, k, 5] = -ray[k] / rho**2
    return points, J


@njit(cache=True, error_model="numpy")
def linearity(features: np.ndarray, rho_variance: np.ndarray, position_m: np.ndarray) -> np.ndarray:
    """(n,): how nonlinear the coordinates would be; 0.1 and less is linear enough.

    Source: [Civera2008] Eq. 38: 4 sigma_d / d1 |cos alpha|, with the depth's standard deviation
    sigma_d, the distance d1 from the camera now, and the parallax alpha.
    """
    index = np.full(len(features), np.inf)
    now = np.empty(3)
    for i in range(len(features)):
        rho = features[i, 5]
        if not rho > 0.0:
            continue
        ray, _, _ = _ray(features[i, 3], features[i, 4])
        for k in range(3):
            now[k] = features[i, k] + ray[k] / rho - position_m[k]
        square = dot(now, now)
        value = 4.0 * math.sqrt(rho_variance[i]) / rho**2 / square * abs(dot(ray, now))
        if math.isfinite(value):
            index[i] = value
    return index


@njit(cache=True, error_model="numpy")
def _ray(azimuth: float, elevation: float) -> tuple[tuple[float, float, float], ...]:
    """The unit vector in the world, and its derivatives by the two angles."""
    ca, sa = math.cos(azimuth), math.sin(azimuth)
    ce, se = math.cos(elevation), math.sin(elevation)
    return (ce * ca, ce * sa, se), (-ce * sa, ce * ca, 0.0), (-se * ca, -se * sa, ce)


class LandmarkTable:
    """Who the landmarks are, where their numbers stand, and how often they were found.

    One row for each landmark, in the order of the state.
    """

    def __init__(self) -> None:
        self.ids = np.empty(0, np.int64)
        self.sizes = np.empty(0, np.int64)
        """Numbers of each landmark."""
        self.starts = np.empty(0, np.int64)
        """The first of each landmark's numbers in the state."""
        self.tried = np.empty(0, np.int64)
        """Number of images in which each landmark was measured."""
        self.found = np.empty(0, np.int64)
        """Number of these in which the measurement was believed."""
        self.last_seen = np.empty(0, np.int64)
        """Iteration of the last measurement."""
        self._order = np.empty(0, np.int64)

    def __len__(self) -> int:
        return len(self.ids)

    def rows_of(self, ids: NDArray[np.int64]) -> NDArray[np.int64]:
        """(n,): the row of each id; -1 for an unknown one."""
        if not len(self):
            return np.full(len(ids), -1)
        place = np.searchsorted(self.ids, ids, sorter=self._order)
        rows = self._order[np.minimum(place, len(self) - 1)]
        return np.where(self.ids[rows] == ids, rows, -1)

    def indices(self, rows: NDArray[np.int64], size: int) -> NDArray[np.int64]:
        """(n, size): where the numbers of landmarks of that size stand in the state."""
        return self.starts[rows][:, None] + np.arange(size)

    def add(self, ids: NDArray[np.int64], iteration: int) -> None:
        """New landmarks at the end, by inverse depth."""
        n = len(ids)
        self.ids = np.concatenate([self.ids, ids])
        self.sizes = np.concatenate([self.sizes, np.full(n, INVERSE_DEPTH)])
        self.tried = np.concatenate([self.tried, np.ones(n, np.int64)])
        self.found = np.concatenate([self.found, np.ones(n, np.int64)])
        self.last_seen = np.concatenate([self.last_seen, np.full(n, iteration)])
        self._place()

    def to_coordinates(self, rows: NDArray[np.int64]) -> None:
        """Landmarks (n,) have three numbers from now on."""
        self.sizes[rows] = COORDINATES
        self._place()

    def keep(self, is_kept: NDArray[np.bool_]) -> None:
        """Forgets the others."""
        for name in ("ids", "sizes", "tried", "found", "last_seen"):
            setattr(self, name, getattr(self, name)[is_kept])
        self._place()

    def _place(self) -> None:
        self._order = np.argsort(self.ids)
        self.starts = POSE + np.cumsum(self.sizes) - self.sizes
