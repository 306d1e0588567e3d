import math

import numpy as np
import pytest
from scenes import TOP_Z_M, pixel_of_world

from tracker.base import Status, WarpEstimate
from tracker.belt.backproject import BackprojectConfig, Backprojector
from tracker.belt.image import ArrayImage


def estimate(warp, **changes):
    base = dict(
        warp=warp,
        covariance=1e-6 * np.eye(6),
        ess=50.0,
        log_likelihood=0.0,
        ncc=0.95,
        visible_fraction=1.0,
        status=Status.TRACKING,
    )
    return WarpEstimate(**(base | changes))


@pytest.fixture
def projector(template, view):
    return Backprojector(template, view, BackprojectConfig())


@pytest.fixture(scope="module")
def image(view, camera):
    from scenes import Scene

    return view.rectify(ArrayImage(*Scene(*camera).render(0.52, -0.1, 0.4)))


@pytest.mark.parametrize("yaw", [-3.0, -1.2, 0.0, 0.4, 2.5])
def test_true_warp_gives_true_pose(projector, view, image, true_warp, unit_px, yaw):
    pose = projector.pose(estimate(true_warp(0.52, -0.1, yaw)), image, unit_px, 0.5)
    np.testing.assert_allclose(pose.position_m, [0.52, -0.1, TOP_Z_M], atol=1e-3)
    assert math.remainder(pose.yaw_rad - yaw, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)
    T = view.T_world_camera
    np.testing.assert_allclose(T[:3, :3] @ pose.position_camera_m + T[:3, 3], pose.position_m)
    assert pose.is_usable
    assert pose.time_s == 0.5


def test_a_box_of_another_height_is_lifted_along_the_ray(projector, view, camera, unit_px):
    """Top face 10 mm above the plane: the plane intersection is off, the lifted point is not."""
    raised = 0.01
    position = np.array([0.52, -0.1, TOP_Z_M + raised])
    origin = view.T_world_camera[:3, 3]
    on_plane = origin + (origin[2] - TOP_Z_M) / (origin[2] - position[2]) * (position - origin)
    from tracker.affine import aff2
    from tracker.belt.rectify import OverheadImage

    shape = view.shape_px
    image = OverheadImage(
        np.zeros(shape, np.uint8), np.ones(shape, np.uint8), np.full(shape, raised, np.float32)
    )
    warp = aff2.similarity(unit_px, 0.3, pixel_of_world(view, on_plane))
    pose = projector.pose(estimate(warp), image, unit_px, 0.0)
    np.testing.assert_allclose(pose.position_m, position, atol=1e-6)


def test_covariance_is_propagated_to_metres(projector, image, view, true_warp, unit_px):
    covariance = np.diag([0, 0, 0.01, 0, 0.02, 0.03]) ** 2
    warp = true_warp(0.52, -0.1, math.pi / 2)  # long axis along y
    pose = projector.pose(estimate(warp, covariance=covariance), image, unit_px, 0.0)
    unit_m = unit_px * view.m_per_px
    np.testing.assert_allclose(pose.covariance[1, 1], (0.02 * unit_m) ** 2, rtol=1e-6)
    np.testing.assert_allclose(pose.covariance[0, 0], (0.03 * unit_m) ** 2, rtol=1e-6)
    np.testing.assert_allclose(pose.covariance[3, 3], 0.01**2, rtol=1e-6)
    assert pose.covariance[2, 2] > 0


@pytest.mark.parametrize(
    "changes",
    [{"visible_fraction": 0.2}, {"status": Status.UNCERTAIN}],
    ids=["mostly hidden", "uncertain"],
)
def test_weak_evidence_is_marked_not_usable(projector, image, true_warp, unit_px, changes):
    pose = projector.pose(estimate(true_warp(0.52, -0.1, 0.4), **changes), image, unit_px, 0.0)
    assert not pose.is_usable


def test_a_wrong_size_is_marked_not_usable(projector, image, true_warp, unit_px):
    from tracker.affine import aff2

    for axis in (0, 1, 3):
        e = np.zeros(6)
        e[axis] = 0.12
        warp = aff2.perturb(true_warp(0.52, -0.1, 0.4), e)
        assert not projector.pose(estimate(warp), image, unit_px, 0.0).is_usable


def test_a_broken_warp_gives_no_pose(projector, image, unit_px):
    broken = np.eye(3)
    broken[0, 2] = np.nan
    assert projector.pose(estimate(broken), image, unit_px, 0.0) is None


@pytest.mark.parametrize(
    ("field", "value"), [("max_height_error_m", 0.0), ("height_gain", 2.0), ("min_depth_count", 0)]
)
def test_bad_settings_are_refused(field, value):
    with pytest.raises(ValueError, match=field):
        BackprojectConfig(**{field: value})
