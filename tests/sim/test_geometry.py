"""Poses, rotations and projection against each other and against SciPy."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sim import geometry


def test_what_a_camera_looks_at_is_in_the_middle_of_its_image_and_up_is_up():
    eye, point = np.array([1.5, -0.3, 1.1]), np.array([0.5, 0.2, 0.1])
    T = np.linalg.inv(geometry.look_at(eye, point))
    P = geometry.intrinsics(640, 480, np.radians(50.0)) @ T[:3]
    middle, above = geometry.project(P, np.array([point, np.add(point, [0.0, 0.0, 0.1])]))
    assert middle == pytest.approx([319.5, 239.5])
    assert above[0] == pytest.approx(319.5) and above[1] < 239.0


def test_a_camera_looking_along_up_has_no_upright_image():
    with pytest.raises(ValueError, match="has no upright image"):
        geometry.look_at(np.array([0.0, 0.0, 1.0]), np.zeros(3))
    down = geometry.look_at((0.0, 0.0, 1.0), np.zeros(3), up=(-1.0, 0.0, 0.0))
    assert down[:3, 2] == pytest.approx([0.0, 0.0, -1.0])


def test_the_angle_of_view_and_the_focal_length_belong_together():
    angle_rad = np.radians(geometry.fovy_deg(240, 300.0))
    assert geometry.intrinsics(320, 240, angle_rad)[1, 1] == pytest.approx(300.0)
    edge = geometry.project(
        geometry.intrinsics(320, 240, angle_rad) @ np.eye(3, 4),
        np.array([[0.0, np.tan(angle_rad / 2), 1.0]]),
    )
    assert edge[0, 1] == pytest.approx(239.5)


def test_rotations_are_those_of_scipy():
    roll, yaw, pitch = 0.3, -0.7, 1.1
    R = geometry.rotation(roll, yaw, pitch)
    assert pytest.approx(R) == Rotation.from_euler("ZYX", [roll, yaw, pitch]).as_matrix()
    w, x, y, z = geometry.quaternion(R)
    assert pytest.approx(R) == Rotation.from_quat([x, y, z, w]).as_matrix()
    w, x, y, z = geometry.yaw_quaternion(0.4)
    assert Rotation.from_quat([x, y, z, w]).as_rotvec() == pytest.approx([0.0, 0.0, 0.4])


def test_a_transform_takes_a_rotation_in_either_shape():
    R = geometry.rotation(0.1, 0.2, 0.3)
    T = geometry.transform(R, [1.0, 2.0, 3.0])
    assert np.array_equal(T, geometry.transform(R.ravel(), [1.0, 2.0, 3.0]))
    assert np.array_equal(T @ [0.0, 0.0, 0.0, 1.0], [1.0, 2.0, 3.0, 1.0])


def test_camera_axes_and_mujocos_differ_by_half_a_turn_about_x():
    x, y, z = geometry.MUJOCO_QUAT[1:]
    half_turn = Rotation.from_quat([x, y, z, geometry.MUJOCO_QUAT[0]]).as_matrix()
    assert half_turn == pytest.approx(np.diag(geometry.MUJOCO_AXES))
    assert geometry.R_BODY_CAMERA.T @ geometry.R_BODY_CAMERA == pytest.approx(np.eye(3))
    assert np.array_equal(geometry.R_BODY_CAMERA @ [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
