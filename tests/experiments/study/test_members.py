"""A gzip file that only grows."""

import gzip
import random
import string

import pytest
from experiments.study.members import append_member, keep_members, read_members, write_members

TEXTS = ["head\n", "", "".join(random.Random(0).choices(string.printable, k=60_000)), "end\n"]


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "file.gz"
    for text in TEXTS:
        append_member(path, text)
    return path


def test_members_come_back_and_are_one_gzip_file(path):
    assert [member.text for member in read_members(path)] == TEXTS
    assert gzip.decompress(path.read_bytes()).decode() == "".join(TEXTS)


def test_equal_texts_give_equal_bytes(path, tmp_path):
    write_members(tmp_path / "again.gz", TEXTS)
    assert (tmp_path / "again.gz").read_bytes() == path.read_bytes()


@pytest.mark.parametrize("torn", [1, 7, 20])
def test_a_torn_last_member_is_ignored_and_cut_off(path, torn):
    whole = read_members(path)[-2].end
    path.write_bytes(path.read_bytes()[: whole + torn])
    assert [member.text for member in read_members(path)] == TEXTS[:-1]
    assert path.stat().st_size == whole + torn
    keep_members(path, TEXTS[0], len(TEXTS))
    assert path.stat().st_size == whole


def test_members_that_are_too_many_are_cut_off_and_a_new_file_gets_its_header(path, tmp_path):
    keep_members(path, TEXTS[0], 2)
    assert [member.text for member in read_members(path)] == TEXTS[:3]
    keep_members(tmp_path / "new.gz", TEXTS[0], 0)
    assert [member.text for member in read_members(tmp_path / "new.gz")] == TEXTS[:1]


def test_what_is_no_gzip_is_told(path, tmp_path):
    path.write_bytes(path.read_bytes() + b"not gzip at all")
    with pytest.raises(ValueError, match=r"file\.gz is damaged at byte"):
        read_members(path)
    assert read_members(tmp_path / "none.gz") == []
