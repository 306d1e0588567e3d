import pytest

from experiments.belt.presets import Preset, expand
from experiments.study import manifest

PRESET = Preset("p", "", expand(), (0, 1))


def test_the_hash_depends_on_name_cells_and_seeds():
    hashes = {
        manifest.config_hash(preset)
        for preset in (
            PRESET,
            Preset("q", "", PRESET.cells, PRESET.seeds),
            Preset("p", "", PRESET.cells, (0,)),
            Preset("p", "", expand(tracker=["pf"]), PRESET.seeds),
        )
    }
    assert len(hashes) == 4
    assert manifest.config_hash(PRESET) == manifest.config_hash(Preset("p", "?", expand(), (0, 1)))


def test_each_session_is_noted(tmp_path):
    for worker_count in (1, 2):
        manifest.open_manifest(tmp_path, PRESET, worker_count)
    manifest.close_manifest(tmp_path, ["b", "a", "b"])
    content = manifest.read_manifest(tmp_path)
    assert content is not None
    assert [session["workers"] for session in content["sessions"]] == [1, 2]
    assert content["gl_renderers"] == ["a", "b"]
    assert [path.name for path in tmp_path.iterdir()] == ["manifest.json"]


def test_the_command_is_noted_without_the_folder_it_was_given_in(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "out" / "p").mkdir(parents=True)
    monkeypatch.setattr("sys.argv", ["cli.py", "sweep", "p", "--out", str(tmp_path / "out" / "p")])
    manifest.open_manifest(tmp_path / "out" / "p", PRESET, 1)
    content = manifest.read_manifest(tmp_path / "out" / "p")
    assert content is not None
    assert content["sessions"][0]["command"] == ["beltgrasp", "sweep", "p", "--out", "out/p"]


def test_a_broken_manifest_is_named(tmp_path):
    (tmp_path / "manifest.json").write_text("{")
    with pytest.raises(ValueError, match=r"manifest.json is not valid JSON"):
        manifest.open_manifest(tmp_path, PRESET, 1)


def test_the_code_version_is_one_word():
    version = str(manifest.code_version())
    assert version
    assert not any(character.isspace() or character == "," for character in version)
