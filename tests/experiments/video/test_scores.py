import numpy as np
import pytest

from experiments.video.scores import mean_curves, overlap_and_error, overlaps, sequence_curves

NAN = float("nan")


def boxes(*rows):
    return np.array(rows, float)


def random_boxes(rng, n):
    return np.column_stack([rng.uniform(1, 60, (n, 2)), rng.uniform(10, 60, (n, 2))])


def test_overlap_by_hand():
    """10 x 10 boxes that share 5 x 10: 50 / 150; a box of another size inside: 25 / 100."""
    a = boxes([1, 1, 10, 10], [1, 1, 10, 10], [1, 1, 10, 10], [1, 1, 10, 10])
    b = boxes([6, 1, 10, 10], [3, 3, 5, 5], [11, 1, 10, 10], [1, 1, 10, 10])
    assert overlaps(a, b) == pytest.approx([1 / 3, 0.25, 0.0, 1.0])


def test_centres_are_those_of_pixels():
    """(1 + 9/2, 1 + 9/2) against (4 + 19/2, 1 + 9/2): 8 px."""
    truth = boxes([1, 1, 10, 10], [1, 1, 10, 10])
    _, error_px = overlap_and_error(boxes([1, 1, 10, 10], [4, 1, 20, 10]), truth)
    assert error_px.tolist() == [0, 8]


def test_the_first_frame_counts_as_the_truth():
    truth = boxes([1, 1, 10, 10], [1, 1, 10, 10])
    overlap, error_px = overlap_and_error(boxes([90, 90, 5, 5], [90, 90, 5, 5]), truth)
    assert overlap.tolist() == [1, 0]
    assert error_px[0] == 0


def test_a_perfect_tracker_has_twenty_of_twenty_one():
    truth = random_boxes(np.random.default_rng(0), 50)
    curves = sequence_curves([truth], [truth])
    assert curves.overlap_score == pytest.approx(20 / 21)
    assert curves.distance_precision == 1.0


def test_a_frame_without_a_true_box_is_an_overlap_miss_and_a_precision_hit():
    truth = boxes([1, 1, 10, 10], [0, 5, 10, 10], [NAN, NAN, NAN, NAN], [3, 3, 10, 0])
    curves = sequence_curves([np.tile(truth[0], (4, 1))], [truth])
    assert curves.success[0] == 1 / 4
    assert curves.precision[0] == 1.0


def test_a_prediction_without_area_repeats_the_one_before():
    truth = np.tile([1.0, 1, 10, 10], (6, 1))
    predicted = boxes(
        [2, 1, 10, 10], [NAN] * 4, [3, 1, 10, 10], [9, 9, 0, 5], [NAN] * 4, [9, 9, 5, -1]
    )
    _, error_px = overlap_and_error(predicted, truth)
    assert error_px.tolist() == [0, 1, 2, 2, 2, 2]


def test_success_is_above_and_precision_up_to_the_threshold():
    """An overlap of exactly 0.5 is no success at 0.5; an error of exactly 3 px counts at 3 px."""
    truth = boxes([1, 1, 10, 10], [1, 1, 10, 10])
    half = sequence_curves([boxes([1, 1, 10, 10], [1, 1, 10, 5])], [truth]).success
    assert (half[9], half[10]) == (1.0, 0.5)
    near = sequence_curves([boxes([1, 1, 10, 10], [4, 1, 10, 10])], [truth]).precision
    assert (near[2], near[3]) == (0.5, 1.0)


def test_runs_of_a_sequence_weigh_by_length_and_sequences_do_not():
    """A perfect run of 3 frames and one of 1 + 1 frames of which one misses: 4 of 5 hits."""
    truth = np.tile([1.0, 1, 10, 10], (3, 1))
    miss = boxes([1, 1, 10, 10], [80, 80, 10, 10])
    curves = sequence_curves([truth, miss], [truth, truth[1:]])
    assert curves.distance_precision == 4 / 5
    perfect = sequence_curves([truth], [truth])
    assert mean_curves([curves, perfect]).distance_precision == pytest.approx(0.9)


def test_wrong_shapes_are_refused():
    with pytest.raises(ValueError, match="must agree"):
        overlap_and_error(np.ones((2, 4)), np.ones((3, 4)))


def test_the_curves_are_those_of_the_got10k_toolkit():
    """Where the two differ (invalid truth, repair), [OTB2015]'s own code decides: see above."""
    otb = pytest.importorskip("got10k.experiments").ExperimentOTB
    toolkit = otb.__new__(otb)
    toolkit.nbins_iou, toolkit.nbins_ce = 21, 51
    rng = np.random.default_rng(0)
    for _ in range(20):
        truth = random_boxes(rng, 40)
        predicted = truth + rng.normal(0, 8, truth.shape)
        predicted[:, 2:] = np.maximum(predicted[:, 2:], 2)
        curves = sequence_curves([predicted], [truth])
        predicted[0] = truth[0]
        success, precision = toolkit._calc_curves(*toolkit._calc_metrics(predicted, truth))
        assert np.array_equal(curves.success, success)
        assert np.array_equal(curves.precision, precision)
