import pytest

from experiments.video.calibration import NEES_MEDIAN
from experiments.video.tables import _affine_measures


def test_a_sequence_without_nees_leaves_the_halves_of_the_others_alone(tmp_path):
    """A and C are one half and D the other, for every tracker."""
    files = []
    for name, nees in (("A", "2"), ("B", ""), ("C", "2"), ("D", "4")):
        path = tmp_path / f"{name}.csv"
        path.write_text(f"visible,nees\n1,{nees}\n")
        files.append(path)
    expected = NEES_MEDIAN * (2 / 4 + 2 / 4 + 4 / 2) / 3
    assert _affine_measures(files)["mean_calibrated_nees"] == pytest.approx(expected)
