"""The code and the command that results come from."""

from experiments.study import provenance


def test_the_code_version_is_one_word():
    version = str(provenance.code_version())
    assert version
    assert not any(character.isspace() or character == "," for character in version)


def test_the_command_is_noted_without_the_folder_it_was_given_in(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", ["cli.py", "sweep", "p", "--out", str(tmp_path / "out" / "p")])
    session = provenance.session(3)
    assert session["command"] == ["beltgrasp", "sweep", "p", "--out", "out/p"]
    assert session["workers"] == 3


def test_outside_of_a_repository_the_version_of_the_package_stands_for_the_code(monkeypatch):
    monkeypatch.setattr(provenance, "_git", lambda *_: "")
    version = provenance.code_version.__wrapped__()
    assert str(version) == f"v{provenance.package_version('beltgrasp')}"
    assert provenance.package_version("no-such-package") == "none"


def test_rows_name_the_code(monkeypatch):
    dirty = provenance.CodeVersion("abc", is_dirty=True)
    monkeypatch.setattr(provenance, "code_version", lambda: dirty)
    assert provenance.provenance()["commit"] == "abc-dirty"
    assert provenance.provenance()["mujoco_version"].startswith("3.")
