"""Which subject of the trackers may import which: the arrows point one way."""

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[2] / "tracker"
MAY_IMPORT = {
    "affine": set(),
    "peers": {"affine"},
    "video": {"affine"},
    "belt": {"affine", "peers"},
    "apple": set(),
    "bearing_only": set(),
}


def subjects_imported_by(subject: str) -> set[str]:
    found: set[str] = set()
    for path in (PACKAGE / subject).glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("tracker."):
                names = [f"{node.module}.{alias.name}" for alias in node.names]
                found.update(name.split(".")[1] for name in names)
    return found & set(MAY_IMPORT) - {subject}


def test_every_subject_has_its_arrows():
    assert {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").exists()} == set(
        MAY_IMPORT
    )


@pytest.mark.parametrize("subject", MAY_IMPORT)
def test_a_subject_imports_only_what_stands_under_it(subject):
    assert subjects_imported_by(subject) <= MAY_IMPORT[subject]


def test_the_ground_floor_imports_no_subject():
    for path in PACKAGE.glob("*.py"):
        source = path.read_text(encoding="utf-8")
        assert not [subject for subject in MAY_IMPORT if f"from tracker.{subject}" in source], path
