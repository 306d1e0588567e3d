import numpy as np
import pytest

from tracker.bearing_only.features import (
    angles_jacobian,
    angles_of_ray,
    linearity,
    new_features,
    points_of,
    ray_jacobian,
    ray_of_angles,
    view_inverse_depth,
    view_points,
)
from tracker.bearing_only.frames import rotation_of_vector
from tracker.bearing_only.measurements import PinholeCamera, PoseBelief

CAMERA = PinholeCamera()


@pytest.fixture
def scene():
    rng = np.random.default_rng(3)
    pose = PoseBelief(rng.normal(size=3), rotation_of_vector(0.5 * rng.normal(size=3)), np.eye(6))
    pixels = rng.uniform([50, 50], [590, 430], (6, 2))
    features, by_pose, by_pixel = new_features(CAMERA, pose, pixels, 0.1)
    features[:, 5] = rng.uniform(0.02, 0.4, 6)
    return pose, pixels, features, by_pose, by_pixel


def moved(pose, error):
    R = pose.R_world_body @ rotation_of_vector(error[3:])
    return PoseBelief(pose.position_m + error[:3], R, pose.covariance)


def numeric(function, size, step=1e-6):
    columns = [(function(e) - function(-e)) / (2 * step) for e in step * np.eye(size)]
    return np.stack(columns, axis=-1)


def test_a_new_landmark_is_seen_where_it_was_found(scene):
    pose, pixels, features, *_ = scene
    seen = view_inverse_depth(CAMERA, pose, features)
    assert np.allclose(seen[0], pixels)
    assert seen[3].all()
    assert np.allclose(view_points(CAMERA, pose, points_of(features)[0])[0], pixels)


def test_jacobians_by_pose_and_feature_are_those_of_finite_differences(scene):
    pose, _, features, *_ = scene
    later = moved(pose, np.array([0.3, -0.2, 0.1, 0.01, 0.02, -0.03]))
    _, by_pose, by_feature, _ = view_inverse_depth(CAMERA, later, features)
    of_pose = numeric(lambda e: view_inverse_depth(CAMERA, moved(later, e), features)[0], 6)
    of_feature = numeric(lambda e: view_inverse_depth(CAMERA, later, features + e)[0], 6)
    assert np.allclose(by_pose, of_pose, rtol=1e-5, atol=1e-3)
    assert np.allclose(by_feature, of_feature, rtol=1e-5, atol=1e-3)
    points, J = points_of(features)
    assert np.allclose(J, numeric(lambda e: points_of(features + e)[0], 6), rtol=1e-5, atol=1e-4)
    _, by_pose, by_point, _ = view_points(CAMERA, later, points)
    of_pose = numeric(lambda e: view_points(CAMERA, moved(later, e), points)[0], 6)
    of_point = numeric(lambda e: view_points(CAMERA, later, points + e)[0], 3)
    assert np.allclose(by_pose, of_pose, rtol=1e-5, atol=1e-3)
    assert np.allclose(by_point, of_point, rtol=1e-5, atol=1e-3)


def test_the_birth_s_jacobians_are_those_of_finite_differences(scene):
    pose, pixels, _, by_pose, by_pixel = scene
    of_pose = numeric(lambda e: new_features(CAMERA, moved(pose, e), pixels, 0.1)[0], 6)
    of_pixel = numeric(lambda e: new_features(CAMERA, pose, pixels + e, 0.1)[0], 2)
    assert np.allclose(by_pose, of_pose, atol=1e-6)
    assert np.allclose(by_pixel, of_pixel[:, 3:5], atol=1e-8)


def test_angles_and_rays_are_each_other_s_inverse():
    angles = np.random.default_rng(0).uniform([-3.0, -1.4], [3.0, 1.4], (20, 2))
    rays = ray_of_angles(angles)
    assert np.allclose(np.linalg.norm(rays, axis=1), 1.0)
    assert np.allclose(angles_of_ray(3.0 * rays), angles)
    product = angles_jacobian(rays) @ ray_jacobian(angles)
    assert np.allclose(product, np.eye(2), atol=1e-9)


def test_a_landmark_is_linear_once_its_depth_is_known_or_parallax_is_wide():
    feature = np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 0.1]])  # 10 m along x
    near = np.array([0.0, 0.0, 0.0])
    # 4 sigma_d / d |cos| = 4 * 0.01 / 0.1^2 / 10 = 0.4
    assert np.isclose(linearity(feature, np.array([0.01**2]), near)[0], 0.4)
    aside = np.array([10.0, 10.0, 0.0])  # parallax of a right angle
    assert np.isclose(linearity(feature, np.array([0.01**2]), aside)[0], 0.0)
    behind = feature * [1, 1, 1, 1, 1, -1]
    assert linearity(behind, np.array([1.0]), near)[0] == np.inf
