import numpy as np
import pytest
import scipy.stats

from experiments.video.affine_scores import (
    NEES_MEDIAN,
    AffineReferee,
    calibrated,
    nees,
    resampling_distance,
)
from experiments.video.sequences import AffineTruth
from tracker.affine import aff2
from tracker.affine.resampling import Particles
from tracker.base import Status, WarpEstimate
from tracker.box_tracker import BoxEstimate

BOX = np.array([10.0, 12.0, 20.0, 5.0])
UNIT = 10.0
START = np.array([[UNIT, 0, 19.5], [0, UNIT, 14.0], [0, 0, 1]])
CORNERS = np.array([[-1, -0.25], [1, -0.25], [1, 0.25], [-1, 0.25]])


def place(warp):
    return CORNERS @ warp[:2, :2].T + warp[:2, 2]


def truth(*warps):
    stack = np.array(warps, float)
    return AffineTruth(stack, np.array([place(warp) for warp in stack]), np.ones(len(stack)))


def estimate(warp, covariance=None):
    covariance = np.eye(6) if covariance is None else covariance
    known = WarpEstimate(warp, covariance, 50.0, 0.0, 1.0, 1.0, Status.TRACKING)
    return BoxEstimate(np.array([0.0, 0, 1, 1]), known)


def resampled(weights, parents, spread=1.0):
    """Particles in a row along x, resampled to copies of `parents`."""
    weights, parents = np.array(weights, float), np.array(parents)
    e = np.zeros((len(weights), 6))
    e[:, 4] = spread * np.arange(len(weights))
    warps = aff2.perturb(START, e)
    even = np.full(len(weights), 1.0 / len(weights))
    with np.errstate(divide="ignore"):
        before = Particles(warps, warps, np.log(weights), np.zeros(len(weights)))
    return before, Particles(warps[parents], warps, np.log(even), np.zeros(len(even)), parents)


def turned(angle_rad, shift=(0, 0)):
    warp = aff2.from_polar(np.array([0, 0, angle_rad, 0, 0, 0]))
    out = START @ warp
    out[:2, 2] += shift
    return out


def test_a_perfect_estimate_has_no_error():
    true = truth(START, turned(0.3, (4, 1)))
    row = AffineReferee(true, "1", 0, BOX).row(1, estimate(true.warps[1]))
    assert (row.run, row.frame, row.visible, row.ess) == ("1", 2, 1.0, 50.0)
    errors = [row.corner_error_px, row.rotation_error_rad, row.scale_error, row.shear_error]
    assert errors == pytest.approx([0] * 4, abs=1e-12)
    assert row.nees == pytest.approx(0, abs=1e-12)
    assert row.ancestor_count is None and row.resampling_distance is None


def test_errors_are_told_one_by_one():
    """3 px to the right and 4 down: every corner is 5 px off; twice the scale: ln 2."""
    true = truth(START, START)
    referee = AffineReferee(true, "1", 0, BOX)
    moved = START.copy()
    moved[:2, 2] += [3, 4]
    assert referee.row(1, estimate(moved)).corner_error_px == pytest.approx(5)
    assert referee.row(1, estimate(turned(0.2))).rotation_error_rad == pytest.approx(0.2)
    grown = START @ np.diag([2.0, 2.0, 1.0])
    assert referee.row(1, estimate(grown)).scale_error == pytest.approx(np.log(2))


def test_a_run_from_a_later_frame_or_another_box_is_judged_by_its_motion():
    """The target is turned when the run starts; the template is the upright box, disturbed."""
    true = truth(START, turned(0.5, (5, 5)), turned(0.8, (9, 5)))
    box = np.array([14.0, 15.0, 24.0, 9.0])
    unit = np.sqrt(24 * 9)
    start = np.array([[unit, 0, 14 + 11.5], [0, unit, 15 + 4.0], [0, 0, 1]])
    motion = true.warps[2] @ aff2.inverse(true.warps[1])
    row = AffineReferee(true, "left", 1, box).row(2, estimate(motion @ start))
    assert row.corner_error_px == pytest.approx(0, abs=1e-9)
    assert row.rotation_error_rad == pytest.approx(0, abs=1e-9)


def test_a_tracker_of_boxes_has_a_corner_error_alone():
    """The target turns by a right angle about its centre; the box that stays is off by the turn."""
    true = truth(START, turned(np.pi / 2))
    row = AffineReferee(true, "1", 0, BOX).row(1, BoxEstimate(BOX))
    distance = np.linalg.norm(place(START) - place(turned(np.pi / 2)), axis=1).mean()
    assert row.corner_error_px == pytest.approx(distance)
    assert row.nees is None and row.ess is None and row.rotation_error_rad is None
    wide = AffineReferee(truth(START, START), "1", 0, BOX).row(
        1, BoxEstimate(np.array([10.0, 12.0, 22.0, 5.0]))
    )
    assert wide.corner_error_px == pytest.approx(1.0)  # the left corners 0, the right ones 2


def test_nees_by_hand():
    """A shift of 0.3 units with a deviation of 0.1 in x: 9."""
    error = np.array([0, 0, 0, 0, 0.3, 0])
    covariance = np.diag([1, 1, 1, 1, 0.01, 1.0])
    assert nees(estimate(START, covariance).affine, START @ aff2.exp(error)) == pytest.approx(9)
    assert nees(estimate(START, np.zeros((6, 6))).affine, START) is None


def test_exact_copies_leave_the_distribution_alone():
    copies = resampled([0.5, 0.25, 0.25, 0], [0, 0, 1, 2])
    assert resampling_distance(START, *copies) == pytest.approx(0)


def test_resampling_distance_of_a_hand_computed_case():
    """Weights 1/2 at 0 and at 2 deviations; all particles at 0: 2 E|X-Y| - E|X-X'| = 2 - 1."""
    for spread in (0.1, 3.0):
        kept = resampled([0.5, 0.5], [0, 0], spread)
        assert resampling_distance(START, *kept) == pytest.approx(1.0)


def test_the_row_counts_ancestors_once():
    known = resampled([0.4, 0.3, 0.3], [0, 0, 2])
    referee = AffineReferee(truth(START), "1", 0, BOX)
    referee.note_resampling(*known)
    row = referee.row(0, estimate(START))
    assert row.ancestor_count == 2
    assert row.resampling_distance == pytest.approx(resampling_distance(START, *known))
    later = referee.row(0, estimate(START))
    assert later.ancestor_count is None and later.resampling_distance is None


def test_the_median_is_that_of_the_distribution():
    assert pytest.approx(scipy.stats.chi2.median(6), abs=5e-4) == NEES_MEDIAN


def test_each_half_gets_the_factor_of_the_other():
    by_name = {"A": [2 * NEES_MEDIAN], "B": [NEES_MEDIAN, 4 * NEES_MEDIAN, 9.0 * NEES_MEDIAN]}
    expected = [2 / 4, 1 / 2, 4 / 2, 9 / 2]
    np.testing.assert_allclose(calibrated(by_name), np.array(expected) * NEES_MEDIAN)


def test_a_factor_common_to_all_sequences_drops_out():
    rng = np.random.default_rng(0)
    by_name = {name: 7.0 * rng.chisquare(6, 400) for name in "ABCDEF"}
    assert calibrated(by_name).mean() == pytest.approx(6.0, rel=0.05)


@pytest.mark.parametrize(
    "by_name", [{}, {"A": [1.0]}, {"A": [1.0], "B": []}, {"A": [0.0], "B": [1]}]
)
def test_nothing_to_calibrate_with_gives_nothing(by_name):
    assert len(calibrated(by_name)) == 0
