"""Compiled loops over the landmarks of a map: pixels, coordinates, and how far from linear."""

import math

import numpy as np
from numba import njit

from tracker.bearing_only.landmarks import INVERSE_DEPTH, POSE
from tracker.bearing_only.observation_loops import see
from tracker.bearing_only.small_matrices import dot

_NO_RAY = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


@njit(cache=True, error_model="numpy")
def view(
    intrinsics_px: np.ndarray,
    position_m: np.ndarray,
    R_world_body: np.ndarray,
    x: np.ndarray,
    places: np.ndarray,
    sizes: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """`features.view_landmarks` of (n,) landmarks whose numbers begin at x[places]."""
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
    """`features.points_of`."""
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
    """`features.linearity`."""
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
