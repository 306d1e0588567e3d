"""CITATION.cff is well formed, and says of project and papers what the other documents say."""

import re
import tomllib
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def citation():
    return yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))


def test_it_has_what_the_format_requires(citation):
    """https://citation-file-format.github.io: these keys, and three of each reference."""
    assert citation["cff-version"] == "1.2.0"
    assert {"message", "title", "authors"} <= set(citation)
    assert all({"type", "title", "authors"} <= set(entry) for entry in citation["references"])
    for entry in (citation, *citation["references"]):
        people = ({"name"}, {"given-names", "family-names"})
        assert all(set(author) in people for author in entry["authors"])
        assert all(
            isinstance(value, str) for author in entry["authors"] for value in author.values()
        )


def test_version_and_licence_are_those_of_the_project(citation):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert citation["version"] == project["version"]
    assert citation["license"] == project["license"]
    assert citation["title"].startswith(f"{project['name']}: ")


def test_papers_are_those_of_the_references(citation):
    lines = (ROOT / "REFERENCES.md").read_text(encoding="utf-8").splitlines()
    entries = {
        match[1]: line for line in lines if (match := re.match(r"- \*\*(\[\w+\])\*\*", line))
    }
    for paper in citation["references"]:
        entry = entries[paper["notes"]]
        names = [author.get("family-names", author.get("name")) for author in paper["authors"]]
        if paper["type"] != "patent":
            facts = (paper["title"], paper["journal"], *names, paper["year"], paper.get("doi", ""))
            assert all(str(fact) in entry for fact in facts)
