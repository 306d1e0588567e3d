import fruits
import numpy as np
import pytest

from tracker.apple.view import CameraPose, FruitStatus, FruitView, Sighting, found

ELLIPSE = {
    "status": FruitStatus.FOUND,
    "centre_px": np.array([320.0, 240.0]),
    "semi_axes_px": np.array([50.0, 45.0]),
    "major_angle_rad": 0.3,
}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"centre_px": None}, "a found fruit needs"),
        ({"semi_axes_px": np.array([40.0, 45.0])}, "got 40.0, 45.0"),
        ({"semi_axes_px": np.array([40.0, np.nan])}, "semi_axes_px must be finite"),
        ({"major_angle_rad": 3.2}, "got 3.2"),
        ({"calyx_px": np.zeros(3)}, r"calyx_px must have the shape \(2,\), got \(3,\)"),
        ({"arc_fraction": 1.5}, r"arc_fraction must be in \[0, 1\], got 1.5"),
        ({"contour_px": np.zeros((4, 3))}, "contour_px"),
        ({"ellipse_covariance": np.zeros((2, 2))}, "ellipse_covariance"),
    ],
)
def test_a_view_that_cannot_be_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        FruitView(**(ELLIPSE | changes))


def test_a_view_without_a_fruit_needs_no_ellipse_and_is_left_out():
    pose = CameraPose(np.eye(3), np.zeros(3))
    good = Sighting(FruitView(**ELLIPSE), fruits.K, pose)
    bad = [Sighting(FruitView(s), fruits.K, pose) for s in FruitStatus if s != FruitStatus.FOUND]
    assert found([*bad, good]) == [good]


def test_arrays_cannot_be_changed():
    view = FruitView(**ELLIPSE)
    with pytest.raises(ValueError, match="read-only"):
        view.centre_px[0] = 0.0


@pytest.mark.parametrize(
    ("rotation", "message"),
    [
        (1.01 * np.eye(3), "unit length"),
        (np.diag([1.0, 1.0, -1.0]), "determinant -1"),
        (np.full((3, 3), np.nan), "finite"),
        (np.eye(2), "shape"),
    ],
)
def test_a_pose_that_is_no_rotation_is_refused(rotation, message):
    with pytest.raises(ValueError, match=message):
        CameraPose(rotation, np.zeros(3))


def test_intrinsics_with_skew_are_refused():
    K = fruits.K.copy()
    K[0, 1] = 2.0
    with pytest.raises(ValueError, match="K must be"):
        Sighting(FruitView(**ELLIPSE), K, CameraPose(np.eye(3), np.zeros(3)))
