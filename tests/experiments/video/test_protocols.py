from pathlib import Path

import numpy as np
import pytest

from experiments.video.protocols import runs_of, spatial, temporal
from experiments.video.sequences import SequenceError, VideoSequence


def sequence(boxes, size_px=(200, 100), no_start=()):
    boxes = np.array(boxes, float)
    made = VideoSequence("S", Path("S/gt.txt"), (), boxes, no_start=no_start)
    made.__dict__["size_px"] = size_px
    return made


def starts(frame_count, **kwargs):
    """First frames of TRE, counted from 1 as in the reference code."""
    box = kwargs.pop("box", lambda k: (5, 5, 10, 10))
    made = sequence([box(k) for k in range(1, frame_count + 1)], **kwargs)
    return [run.first + 1 for run in temporal(made)]


def test_one_pass_starts_at_the_first_box():
    (run,) = runs_of("ope", sequence([(5, 6, 7, 8), (9, 9, 9, 9)]))
    assert (run.name, run.first, run.box.tolist()) == ("1", 0, [5, 6, 7, 8])


def test_twenty_runs_are_spread_over_the_frames_with_twenty_to_go():
    """m = 38: floor(1 : 2 : 38) = 1, 3, ..., 37, and 38."""
    assert starts(57) == [*range(1, 38, 2), 38]


def test_starts_are_rounded_down():
    """Deer: 71 frames, m = 52, steps of 52/19 = 2.737."""
    expected = [1, 3, 6, 9, 11, 14, 17, 20, 22, 25, 28, 31, 33, 36, 39, 42, 44, 47, 50, 52]
    assert starts(71) == expected


def test_few_frames_start_some_runs_twice_and_are_fewer():
    """m = 2: floor(1 : 2/19 : 2) = ten ones (1 + 9 * 2/19 = 1.95), and 2."""
    assert starts(21) == [1] * 10 + [2]
    assert starts(20) == [1, 1]
    assert starts(19) == [1]


def test_frames_without_a_valid_box_do_not_start():
    """Frames 1, 4, 5, ...: m = 38 of the 60 frames that leave 20 to go from frame 41 at most."""
    found = starts(60, box=lambda k: (5, 5, 10, 10) if k not in (2, 3, 4) else (0, 0, 0, 0))
    assert found == [1, *(k + 3 for k in range(3, 38, 2)), 41]
    assert starts(60, box=lambda k: (5, 5, 10, 10 if k != 1 else float("nan")))[0] == 2


def test_no_run_starts_where_the_benchmark_forbids_it():
    found = starts(60, no_start=((2, 4), (58, 70)))
    assert found == [1, *(k + 3 for k in range(3, 38, 2)), 41]


def boxes_of(box, size_px=(200, 100)):
    return {run.name: run.box.tolist() for run in spatial(sequence([box], size_px))}


def test_the_twelve_disturbances_of_a_box_by_hand():
    """w = 25: ceil(2.5) = 3 for shifts; corners round(x - 2.5), halves away from zero."""
    assert boxes_of((50, 40, 25, 14)) == {
        "left": [47, 40, 25, 14],
        "right": [53, 40, 25, 14],
        "up": [50, 38, 25, 14],
        "down": [50, 42, 25, 14],
        "top-left": [48, 39, 27, 15],  # round(47.5) = 48, round(38.6) = 39; ends at 74, 53
        "top-right": [50, 39, 28, 15],  # ends at round(74 + 2.5) = 77
        "bottom-left": [48, 40, 27, 15],  # ends at round(53 + 1.4) = 54
        "bottom-right": [50, 40, 28, 15],
        "scale-0.8": [53, 41, 20, 11],  # centre 62.5, 47: round(52.5) = 53, round(41.4) = 41
        "scale-0.9": [51, 41, 23, 13],  # round(51.25), round(40.7), round(22.5), round(12.6)
        "scale-1.1": [49, 39, 28, 15],  # round(48.75), round(39.3), round(27.5), round(15.4)
        "scale-1.2": [48, 39, 30, 17],  # round(47.5), round(38.6), 30, round(16.8)
    }


def test_a_disturbed_box_is_moved_in_at_the_left_and_cut_off_at_the_right():
    assert boxes_of((2, 1, 30, 20))["left"] == [1, 1, 30, 20]
    assert boxes_of((2, 1, 30, 20))["up"] == [2, 1, 30, 20]
    assert boxes_of((171, 81, 30, 20))["right"] == [174, 81, 27, 20]
    assert boxes_of((171, 81, 30, 20))["down"] == [171, 83, 30, 18]
    assert boxes_of((171, 81, 30, 20))["bottom-right"] == [171, 81, 30, 20]
    assert boxes_of((1, 1, 30, 20))["scale-1.2"] == [1, 1, 36, 24]


@pytest.mark.parametrize(
    ("box", "reason"),
    [
        ((5, 5, 0, 7), "has no area"),
        ((5, 5, 7, -1), "has no area"),
        ((5, 5, float("nan"), 7), "has no area"),
        ((201, 5, 7, 7), "is outside the image of 200 x 100 px"),
        ((5, -10, 7, 11), "is outside the image"),
    ],
)
def test_a_start_from_a_box_that_shows_nothing_is_refused(box, reason):
    with pytest.raises(SequenceError, match=rf"S/gt.txt, line 1: the box .* {reason}"):
        runs_of("ope", sequence([box]))


def test_a_box_that_is_partly_outside_is_let_through():
    assert runs_of("ope", sequence([(-3, -3, 10, 10)]))
