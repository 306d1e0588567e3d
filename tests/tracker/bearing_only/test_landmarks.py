import numpy as np
import pytest

from tracker.bearing_only.landmarks import (
    COORDINATES,
    INVERSE_DEPTH,
    angles_jacobian,
    angles_of_ray,
    linearity,
    new_features,
    points_of,
    view_landmarks,
)
from tracker.bearing_only.measurements import PinholeCamera, PoseBelief
from tracker.geometry import rotation_of_vector

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


def view(pose, landmarks):
    """`view_landmarks` of (n, 6) or (n, 3) numbers."""
    n, size = landmarks.shape
    places = size * np.arange(n)
    assert size in (INVERSE_DEPTH, COORDINATES)
    return seen_from(pose, landmarks.reshape(-1), places, np.full(n, size))


def seen_from(pose, x, places, sizes):
    here = pose.position_m, pose.R_world_body
    return view_landmarks(CAMERA.intrinsics_px, *here, x, places, sizes)


def numeric(function, size, step=1e-6):
    columns = [(function(e) - function(-e)) / (2 * step) for e in step * np.eye(size)]
    return np.stack(columns, axis=-1)


def test_a_new_landmark_is_seen_where_it_was_found(scene):
    pose, pixels, features, *_ = scene
    seen = view(pose, features)
    assert np.allclose(seen[0], pixels)
    assert seen[3].all()
    assert np.allclose(view(pose, points_of(features)[0])[0], pixels)


def test_jacobians_by_pose_and_feature_are_those_of_finite_differences(scene):
    pose, _, features, *_ = scene
    later = moved(pose, np.array([0.3, -0.2, 0.1, 0.01, 0.02, -0.03]))
    points, J = points_of(features)
    assert np.allclose(J, numeric(lambda e: points_of(features + e)[0], 6), rtol=1e-5, atol=1e-4)
    for landmarks in (features, points):
        size = landmarks.shape[1]
        _, by_pose, by_landmark, _ = view(later, landmarks)
        of_pose = numeric(lambda e, known=landmarks: view(moved(later, e), known)[0], 6)
        of_landmark = numeric(lambda e, known=landmarks: view(later, known + e)[0], size)
        assert np.allclose(by_pose, of_pose, rtol=1e-5, atol=1e-3)
        assert np.allclose(by_landmark[:, :, :size], of_landmark, rtol=1e-5, atol=1e-3)
        assert not by_landmark[:, :, size:].any()


def test_landmarks_of_both_kinds_are_seen_as_each_alone(scene):
    pose, pixels, features, *_ = scene
    points, _ = points_of(features)
    x = np.concatenate([points[0], features[1], points[2], features[3]])
    places, sizes = np.array([0, 3, 9, 12]), np.array([3, 6, 3, 6])
    seen, alone = seen_from(pose, x, places, sizes), view(pose, features[:4])
    assert np.allclose(seen[0], pixels[:4])
    np.testing.assert_array_equal(seen[2][[1, 3]], alone[2][[1, 3]])


def test_one_behind_is_told_and_has_finite_derivatives(scene):
    pose = scene[0]
    behind = pose.position_m - 5.0 * pose.R_world_body[:, 0]
    pixels, by_pose, by_point, is_in_front = view(pose, behind[None])
    assert not is_in_front.any()
    assert all(np.isfinite(values).all() for values in (pixels, by_pose, by_point))


def test_the_birth_s_jacobians_are_those_of_finite_differences(scene):
    pose, pixels, _, by_pose, by_pixel = scene
    of_pose = numeric(lambda e: new_features(CAMERA, moved(pose, e), pixels, 0.1)[0], 6)
    of_pixel = numeric(lambda e: new_features(CAMERA, pose, pixels + e, 0.1)[0], 2)
    assert np.allclose(by_pose, of_pose, atol=1e-6)
    assert np.allclose(by_pixel, of_pixel[:, 3:5], atol=1e-8)


def test_angles_and_rays_are_each_other_s_inverse():
    angles = np.random.default_rng(0).uniform([-3.0, -1.4], [3.0, 1.4], (20, 2))
    around = np.column_stack([np.zeros((20, 3)), angles, np.ones(20)])
    rays, J = points_of(around)
    assert np.allclose(np.linalg.norm(rays, axis=1), 1.0)
    assert np.allclose(angles_of_ray(3.0 * rays), angles)
    product = angles_jacobian(rays) @ J[:, :, 3:5]
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
