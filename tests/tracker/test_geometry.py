import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from tracker.geometry import (
    R_BODY_CAMERA,
    camera_rotation,
    least_rotation,
    project,
    rays_of,
    rotation_about_fixed_axes,
    rotation_of_euler,
    rotation_of_vector,
    skew,
)

vectors = arrays(float, (4, 3), elements=st.floats(-3.0, 3.0))


@given(vectors)
def test_rotation_vectors_are_those_of_scipy(phi):
    assert np.allclose(rotation_of_vector(phi), Rotation.from_rotvec(phi).as_matrix(), atol=1e-12)


def test_a_tiny_rotation_is_exact_to_second_order():
    phi = np.array([1e-8, -2e-8, 3e-8])
    assert np.allclose(rotation_of_vector(phi), np.eye(3) + skew(phi), atol=1e-15)


@given(vectors)
def test_euler_increments_are_about_the_axes_of_the_body(phi):
    expected = Rotation.from_euler("ZYX", phi[:, ::-1]).as_matrix()
    assert np.allclose(rotation_of_euler(phi), expected, atol=1e-12)


@given(arrays(float, 3, elements=st.floats(-1e-4, 1e-4)))
def test_the_seed_s_quaternion_step_is_a_body_increment_to_first_order(phi):
    """[Wu2022] Eq. 2: q + Omega(phi) q / 2, scalar first, then normalised."""
    q = Rotation.from_rotvec([0.3, -0.5, 0.9]).as_quat(scalar_first=True)
    r, p, y = phi
    omega = np.array([[0, -r, -p, -y], [r, 0, y, -p], [p, -y, 0, r], [y, p, -r, 0]])
    stepped = Rotation.from_quat(q + 0.5 * omega @ q, scalar_first=True).as_matrix()
    before = Rotation.from_quat(q, scalar_first=True).as_matrix()
    assert np.allclose(stepped, before @ rotation_of_euler(phi), atol=1e-7)


def test_the_camera_looks_along_the_body_s_x_axis():
    assert np.array_equal(R_BODY_CAMERA @ [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    assert np.array_equal(R_BODY_CAMERA @ [1.0, 0.0, 0.0], [0.0, -1.0, 0.0])  # right is -left
    assert np.array_equal(R_BODY_CAMERA @ [0.0, 1.0, 0.0], [0.0, 0.0, -1.0])  # down is -up
    assert np.isclose(np.linalg.det(camera_rotation(np.eye(3))), 1.0)


def test_turns_about_fixed_axes_follow_the_order():
    """90 degrees about x send y to z; those about y then z to x, or come too early."""
    angles = np.array([90.0, 90.0, 0.0])
    y = np.array([0.0, 1.0, 0.0])
    np.testing.assert_allclose(rotation_about_fixed_axes("xyz", angles) @ y, [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(rotation_about_fixed_axes("yxz", angles) @ y, [0, 0, 1], atol=1e-12)


@given(arrays(float, (2, 3), elements=st.floats(0.1, 3.0)))
def test_the_least_rotation_turns_about_the_common_normal(pair):
    start, end = pair
    R = least_rotation(start, end)
    aligned = R @ start / np.linalg.norm(start)
    np.testing.assert_allclose(aligned, end / np.linalg.norm(end), atol=1e-9)
    normal = np.cross(start, end)
    np.testing.assert_allclose(R @ normal, normal, atol=1e-7)


@given(arrays(float, (2, 2), elements=st.floats(0.0, 480.0)), st.floats(0.5, 80.0))
def test_rays_and_pixels_are_inverse(pixels, depth_m):
    K = np.array([[525.0, 0.0, 319.5], [0.0, 500.0, 239.5], [0.0, 0.0, 1.0]])
    rays = rays_of(pixels, K)
    np.testing.assert_allclose(rays @ K.T, np.column_stack([pixels, [1.0, 1.0]]), atol=1e-9)
    np.testing.assert_allclose(project(depth_m * rays, K), pixels, atol=1e-9)
