import pytest

from experiments.video.affine_scores import NEES_MEDIAN
from experiments.video.job import AFFINE_COLUMNS
from experiments.video.tables import _affine_measures


def test_a_sequence_without_nees_leaves_the_halves_of_the_others_alone():
    """A and C are one half and D the other, for every tracker."""
    lines = []
    for name, nees in (("A", "2"), ("B", ""), ("C", "2"), ("D", "4")):
        known = {"sequence": name, "visible": "1", "nees": nees}
        lines.append(",".join(known.get(column, "") for column in AFFINE_COLUMNS))
    expected = NEES_MEDIAN * (2 / 4 + 2 / 4 + 4 / 2) / 3
    assert _affine_measures(lines)["mean_calibrated_nees"] == pytest.approx(expected)
