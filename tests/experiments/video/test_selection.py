import pytest

from experiments.video.selection import read_list, select

SEQUENCES = {"Deer": ("MB", "FM"), "Mine": (), "Skiing": ("SV",)}


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["Skiing", "Deer"], ["Deer", "Skiing"]),
        (["MB", "SV"], ["Deer", "Skiing"]),
        (["FM", "Mine"], ["Deer", "Mine"]),
        (["TB-50"], ["Deer", "Skiing"]),
    ],
)
def test_names_and_attributes_choose(words, expected):
    assert select(SEQUENCES, [(word, "--only") for word in words]) == (expected, [])


def test_an_unknown_word_is_told_and_the_others_count():
    chosen, complaints = select(SEQUENCES, [("Dear", "list.txt, line 2"), ("Mine", "--only")])
    assert chosen == ["Mine"]
    (line,) = complaints
    assert line.startswith("list.txt, line 2: no sequence or attribute 'Dear'; did you mean 'Deer'")
    assert select(SEQUENCES, [("LR", "--only")])[1] == ["--only: no sequence is of LR"]


def test_a_list_holds_a_name_a_line(tmp_path):
    path = tmp_path / "tb_50.txt"
    path.write_text("Deer\tMB, FM\n\n# a comment\nSkiing # another\n")
    assert read_list(path) == [("Deer", f"{path}, line 1"), ("Skiing", f"{path}, line 4")]
    path.write_text("\n")
    with pytest.raises(ValueError, match="names no sequence"):
        read_list(path)
