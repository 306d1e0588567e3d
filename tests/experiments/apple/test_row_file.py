"""Rows in groups: what survives a kill, and in which order they end."""

from dataclasses import dataclass

import pytest
from experiments.apple.row_file import RowFile


@dataclass(frozen=True)
class Row:
    world: str
    seed: int
    value: float | None
    is_good: bool


def group(world, seed):
    return [Row(world, seed, 0.5, True), Row(world, seed, None, False)]


def rows_in(tmp_path):
    return RowFile(tmp_path / "rows.csv", Row, ("world", "seed"), lambda row: 2)


def test_rows_come_back_as_they_were(tmp_path):
    rows = rows_in(tmp_path)
    rows.append(group("a", 1))
    rows.append(group("b", 0))
    assert rows.read() == group("a", 1) + group("b", 0)
    assert rows.path.read_text().splitlines()[:2] == ["world,seed,value,is_good", "a,1,0.5,true"]


@pytest.mark.parametrize("cut", range(1, 20))
def test_a_torn_group_is_cut_off_and_the_rest_kept(tmp_path, cut):
    rows = rows_in(tmp_path)
    rows.append(group("a", 1))
    whole = rows.path.read_bytes()
    rows.append(group("b", 0))
    rows.path.write_bytes(rows.path.read_bytes()[:-cut])
    assert rows.read() == group("a", 1)
    assert rows.resume() == {("a", 1)}
    assert rows.path.read_bytes() == whole


def test_sorting_makes_files_equal_whatever_ended_first(tmp_path):
    files = []
    for name, order in (("x", [0, 1, 2]), ("y", [2, 0, 1])):
        (tmp_path / name).mkdir()
        rows = rows_in(tmp_path / name)
        for seed in order:
            rows.append(group("a", seed))
        rows.sort(lambda key: key)
        files.append(rows.path.read_bytes())
    assert files[0] == files[1]


def test_what_is_no_such_file_is_told(tmp_path):
    rows = rows_in(tmp_path)
    assert rows.resume() == set()
    with pytest.raises(ValueError, match="missing or empty; `beltgrasp apple rows` writes it"):
        rows.read()
    rows.path.write_text("other,columns\n1,2\n")
    with pytest.raises(ValueError, match="columns are those of another version"):
        rows.read()
    rows.path.write_text("world,seed,value,is_good\na,one,0.5,true\n")
    with pytest.raises(ValueError, match="line 2 is not a valid row"):
        rows.read()
