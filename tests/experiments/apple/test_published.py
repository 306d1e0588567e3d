import numpy as np
import pytest

from experiments.apple.published import IDENTIFIED, TABLES, published_table, readings
from tracker.apple.attitude import PAPER_FROM_OPENCV, angle_between_deg, folded_deg, unit


@pytest.mark.parametrize("number", TABLES)
def test_rows_are_attitudes_to_the_rounding(number):
    """Squared cosines sum to one as nearly as whole degrees allow, so no cell is misread."""
    table = published_table(number)
    assert len(table.robot_deg) == {1: 6, 2: 5}[number]
    for angles in (table.camera_deg, table.robot_deg, table.estimate_deg):
        np.testing.assert_allclose((np.cos(np.radians(angles)) ** 2).sum(axis=1), 1.0, atol=0.01)


def test_cells_by_hand():
    first, second = published_table(1), published_table(2)
    np.testing.assert_allclose(first.position_m[3], [0.641176, 0.429229, 0.643852])
    np.testing.assert_allclose(first.fixed_angles_deg[4], [-152.50, -81.79, 4.63])
    np.testing.assert_allclose(first.estimate_deg[-1], [85.53, 79.61, 11.61])
    np.testing.assert_allclose(second.camera_deg[4], [76, 98, 16])
    np.testing.assert_allclose(second.robot_deg[2], [40, 53, 77])
    np.testing.assert_allclose(second.estimate_deg[-1], [42.51, 50.70, 76.07])


def test_method_1_made_the_camera_column_of_table_1():
    """Eq. (1): the second angle is 90 degrees more than the first, the third is 90 degrees."""
    camera = published_table(1).camera_deg
    np.testing.assert_allclose(camera[:, 1], camera[:, 0] + 90.0)
    np.testing.assert_allclose(camera[:, 2], 90.0)


@pytest.mark.parametrize(("number", "limit_deg"), [(1, 1.5), (2, 3.1)])
def test_camera_columns_convert_to_robot_columns(number, limit_deg):
    table = published_table(number)
    angles = np.degrees(np.arccos(np.clip(table.converted, -1.0, 1.0)))
    if number == 1:
        assert np.abs(angles - table.robot_deg).max() > 15.0  # printed folded
        angles = folded_deg(angles)
    assert np.abs(angles - table.robot_deg).max() < limit_deg


def test_one_reading_of_the_angles_stands_out():
    best, second = readings()[:2]
    assert best.key == IDENTIFIED
    assert np.mean(second.residual_deg) > 5.0 * np.mean(best.residual_deg)


@pytest.mark.parametrize("number", TABLES)
def test_the_cameras_look_at_one_place(number):
    table = published_table(number)
    for pose, rotation in zip(table.camera_poses, table.rotation, strict=True):
        np.testing.assert_allclose(pose.rotation @ PAPER_FROM_OPENCV.T, rotation)
        aside = angle_between_deg(pose.rotation[:, 2], unit(table.fruit_m - pose.position_m))
        assert aside < 15.0


def test_other_tables_do_not_exist():
    with pytest.raises(ValueError, match="table must be one of 1, 2; got 3"):
        published_table(3)
