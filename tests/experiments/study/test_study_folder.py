"""Which study a folder holds."""

import json

import pytest
from experiments.study.study_folder import claim, study_of


def test_a_study_goes_on_in_its_folder(tmp_path):
    out = tmp_path / "new"
    for _ in range(2):
        claim(out, "apple", "replay", 2, {"masks": ["a"]})
    content = json.loads((out / "manifest.json").read_text())
    assert (content["apple"], content["settings"]) == ("replay", {"masks": ["a"]})
    assert [session["workers"] for session in content["sessions"]] == [2, 2]
    assert study_of(out, "apple", "apple") == "replay"


@pytest.mark.parametrize(
    ("kind", "study", "settings", "message"),
    [
        ("apple", "approach", {"masks": 1}, "holds results of replay, not of approach; choose"),
        ("other", "replay", {"masks": 1}, "holds results of another command, not of replay"),
        ("apple", "replay", {"masks": 2}, "holds results with masks 1, not 2; choose"),
    ],
)
def test_another_study_is_refused_and_leaves_no_trace(tmp_path, kind, study, settings, message):
    claim(tmp_path, "apple", "replay", 1, {"masks": 1})
    before = (tmp_path / "manifest.json").read_bytes()
    with pytest.raises(ValueError, match=message):
        claim(tmp_path, kind, study, 1, settings)
    assert (tmp_path / "manifest.json").read_bytes() == before


def test_rows_without_a_manifest_and_folders_without_a_study_are_refused(tmp_path):
    with pytest.raises(ValueError, match="holds no results of `beltgrasp apple`"):
        study_of(tmp_path, "apple", "apple")
    (tmp_path / "rows.csv").write_text("a\n")
    with pytest.raises(ValueError, match=r"results without their manifest\.json"):
        claim(tmp_path, "apple", "replay", 1)
