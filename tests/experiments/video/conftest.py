"""See `toy_sequences`."""

import pytest
from toy_sequences import paint_sequence, write_affine


@pytest.fixture(scope="session")
def paint():
    """See `paint_sequence`."""
    return paint_sequence


@pytest.fixture
def root(tmp_path):
    """A folder of two sequences, `One` with affine truth."""
    folder = tmp_path / "sequences"
    write_affine(folder / "One", paint_sequence(folder / "One"))
    (folder / "One" / "attrs.txt").write_text("SV, FM\n")
    paint_sequence(folder / "Two", seed=1)
    return folder
