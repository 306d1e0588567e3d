"""What a folder says of itself: its study, selections, settings and runs."""

import json

import pytest
from toy_study import SELECTION, STUDY, TOY

from experiments.study.manifest import FILE, FORMAT, Manifest, Request, claim, jobs_of
from experiments.study.shard import Shard


def request(selection=SELECTION, shard=None):
    return Request.of(STUDY, selection, shard)


def test_it_comes_back_as_it_was_written(tmp_path):
    manifest = claim(tmp_path, STUDY, request(shard=Shard(2, 3)), 4)
    again = Manifest.read(tmp_path)
    assert again == manifest
    assert again.shard == Shard(2, 3)
    assert again.jobs(STUDY) == jobs_of(STUDY, [SELECTION], Shard(2, 3))
    assert [path.name for path in tmp_path.iterdir()] == [FILE]


def test_a_line_has_one_selection_setting_or_run(tmp_path):
    for seeds in ([0], [1]):
        claim(tmp_path, STUDY, request(SELECTION | {"seeds": seeds}), 1)
    lines = (tmp_path / FILE).read_text().splitlines()
    assert lines[1:3] == [f'  "study": "{TOY}",', f'  "format": {FORMAT},']
    assert '    {"methods": ["pf", "igpf"], "seeds": [0]},' in lines
    assert '    "method igpf": {"gain": "1.0"}' in lines
    assert sum(line.startswith('    {"started_utc"') for line in lines) == 2


def test_each_run_is_noted(tmp_path):
    for worker_count in (1, 2):
        claim(tmp_path, STUDY, request(), worker_count)
    sessions = Manifest.read(tmp_path).sessions
    assert [session["workers"] for session in sessions] == [1, 2]


def test_a_folder_that_cannot_be_used_is_not_created(tmp_path):
    assert Manifest.read(tmp_path / "none") is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", r"manifest\.json is not valid JSON: "),
        ("7", "holds results of an earlier version of beltgrasp, whose format this one does not"),
        ('{"apple": "dance"}', "holds results of an earlier version of beltgrasp"),
        (f'{{"study": "a", "format": {FORMAT + 1}}}', "of a later version of beltgrasp; choose"),
        (f'{{"study": "a", "format": {FORMAT}, "x": 1}}', r"manifest\.json is not the manifest of"),
        (f'{{"study": "a", "format": {FORMAT}, "shard": "3/2"}}', "study: shard must be I/N with"),
        (f'{{"study": "a", "format": {FORMAT}, "shard": 3}}', r"manifest\.json is not the mani"),
    ],
)
def test_what_is_no_manifest_of_this_version_is_refused_and_left_alone(tmp_path, text, message):
    (tmp_path / FILE).write_text(text)
    for do in (lambda: Manifest.read(tmp_path), lambda: claim(tmp_path, STUDY, request(), 1)):
        with pytest.raises(ValueError, match=message) as refusal:
            do()
        assert "\n" not in str(refusal.value) and str(tmp_path) in str(refusal.value)
    assert (tmp_path / FILE).read_text() == text


@pytest.mark.parametrize("name", ["rows.csv", "boxes.csv"])
def test_rows_without_a_manifest_are_not_adopted(tmp_path, name):
    (tmp_path / name).write_text("a\n")
    with pytest.raises(ValueError, match=r"holds results without their manifest\.json; choose an"):
        claim(tmp_path, STUDY, request(), 1)
    assert not (tmp_path / FILE).exists()


def test_selections_that_hold_others_take_their_place(tmp_path):
    asked = [{"seeds": [4]}, {"methods": ["igpf"]}, {"methods": ["pf"]}, {"seeds": [7]}, {}]
    counts = []
    for change in asked:
        counts.append(len(claim(tmp_path, STUDY, request(SELECTION | change), 1).selections))
    assert counts == [1, 2, 3, 4, 2]
    assert Manifest.read(tmp_path).selections == [SELECTION, SELECTION | {"seeds": [7]}]


def test_jobs_that_two_selections_share_are_one(tmp_path):
    selections = [SELECTION | {"seeds": seeds} for seeds in ([0, 1], [1, 2])]
    jobs = jobs_of(STUDY, selections, None)
    assert [job.seed for job in jobs] == [0, 0, 1, 1, 2, 2]


def test_code_that_differs_is_noted_and_used(tmp_path, capsys):
    claim(tmp_path, STUDY, request(), 1)
    assert capsys.readouterr().err == ""
    content = json.loads((tmp_path / FILE).read_text())
    content["sessions"][0] |= {"commit": "0123abc", "is_dirty": True}
    (tmp_path / FILE).write_text(json.dumps(content))
    claim(tmp_path, STUDY, request(), 1)
    note = capsys.readouterr().err
    assert note.startswith(f"note: earlier rows in {tmp_path} are of code 0123abc-dirty, not ")
    assert note.count("\n") == 1
