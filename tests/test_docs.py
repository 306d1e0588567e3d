"""What the documents say holds: cited keys, command lines, make verbs and relative links exist."""

from __future__ import annotations

import ast
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest

from experiments import cli
from experiments.belt.config import TrialConfig
from experiments.belt.presets import PRESETS

ROOT = Path(__file__).resolve().parent.parent
CODE = ("sim", "tracker", "experiments", "assets", "benchmarks", "tests")
DOCUMENTS = sorted(
    path
    for pattern in ("*.md", ".github/**/*.md", "docs/**/*.md", "assets/**/*.md", "results/*.md")
    for path in ROOT.glob(pattern)
)
KEY = re.compile(
    r"(?<![\w\])])\[("
    r"[A-Za-z]\w*(?:18|19|20)\d{2}[a-z]?"  # Name2021
    r"|(?=\w*[a-z])[A-Z]{2}\w{3,}"  # UR5DH is not matched by this, IGPFPatent is
    r")\](?!\()"
)
ENTRY = re.compile(r"^- \*\*\[(\w+)\]\*\* \S", re.MULTILINE)
LINK = re.compile(r"\[[^\]\n]*\]\(([^)\s]+)\)|<(?:img|source|video)[^>]*\ssrc=\"([^\"]+)\"")
SHELL_BLOCK = re.compile(r"^```(?:sh|bash|shell|console)\n(.*?)^```", re.MULTILINE | re.DOTALL)
INLINE = re.compile(r"`((?:beltgrasp|make) [^`\n]+)`")
LAUNCHERS = re.compile(r"^(?:\$ +)?(?:uv run +|\.venv/bin/)?")
SYNOPSIS = re.compile(r"[\[\]|…]|\.\.\.")


def docstrings(source: str) -> Iterator[str]:
    """Every string that stands alone: docstrings and the strings under fields."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            if isinstance(node.value.value, str):
                yield node.value.value


def cited(text: str) -> set[str]:
    return set(KEY.findall(text))


def command_lines(text: str) -> list[str]:
    """The lines of shell blocks and the inline commands, without prompt, launcher and comment."""
    blocks = "\n".join(SHELL_BLOCK.findall(text)).replace("\\\n", " ")
    prose = SHELL_BLOCK.sub("", text)
    inline = [command for command in INLINE.findall(prose) if not SYNOPSIS.search(command)]
    lines = [LAUNCHERS.sub("", line.strip()) for line in blocks.splitlines()]
    return [line for line in [*lines, *inline] if line]


def arguments(line: str, program: str) -> list[str] | None:
    """What follows `program` on the line, or None if the line starts another program."""
    words = shlex.split(line, comments=True)
    return words[1:] if words[:1] == [program] else None


def make_verbs() -> set[str]:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    return set(re.findall(r"^([a-z-]+):.*## ", makefile, re.MULTILINE))


def commands_of(program: str) -> list[tuple[str, list[str]]]:
    return [
        (path.relative_to(ROOT).as_posix(), found)
        for path in DOCUMENTS
        for line in command_lines(path.read_text(encoding="utf-8"))
        if (found := arguments(line, program)) is not None
    ]


def is_placeholder(name: str) -> bool:
    """`NAME`, `NAME-1` for a condition, or the import path of a reader's own tracker."""
    return name.rstrip("-0123456789").isupper() or ":" in name


def check_trial(command: cli.Trial | cli.View) -> int:
    from experiments.catalogue import check_names

    config, named = (
        command.config,
        "tracker embodiment camera object motion condition predictor".split(),
    )
    open_fields = [field for field in named if is_placeholder(getattr(config, field))]
    check_names(replace(config, **{f: getattr(TrialConfig(), f) for f in open_fields}))
    return 0


def check_sweep(command: cli.Sweep) -> int:
    return 0 if command.preset in PRESETS or is_placeholder(command.preset) else 1


@pytest.fixture
def parser(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The command line, of which each command checks its names instead of running."""
    monkeypatch.setattr(cli.Trial, "run", check_trial)
    monkeypatch.setattr(cli.View, "run", check_trial)
    monkeypatch.setattr(cli.Sweep, "run", check_sweep)
    monkeypatch.setattr(cli.Merge, "run", lambda self: 0)
    monkeypatch.setattr(cli.Report, "run", lambda self: 0)
    monkeypatch.setattr(cli.Compare, "run", lambda self: 0)
    monkeypatch.setattr(cli.List, "run", lambda self: 0)
    monkeypatch.setattr(cli.Otb, "run", lambda self: 0)
    monkeypatch.setattr(cli.Apple, "run", lambda self: 0)
    monkeypatch.setattr(cli.BearingOnly, "run", lambda self: 0)
    return cli


@pytest.mark.parametrize(
    "path",
    [path for folder in CODE for path in sorted((ROOT / folder).rglob("*.py"))],
    ids=lambda path: path.relative_to(ROOT).as_posix(),
)
def test_cited_keys_are_in_references(path: Path) -> None:
    if path == Path(__file__).resolve():
        pytest.skip("gives wrong keys as examples")
    references = set(ENTRY.findall((ROOT / "REFERENCES.md").read_text(encoding="utf-8")))
    source = path.read_text(encoding="utf-8")
    comments = "\n".join(re.findall(r"#.*", source))
    assert cited("\n".join([*docstrings(source), comments])) <= references


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_a_document_cites_known_keys_and_links_to_what_exists(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    references = set(ENTRY.findall((ROOT / "REFERENCES.md").read_text(encoding="utf-8")))
    assert cited(text) <= references
    assert not broken_links(text, path.parent)


def links(text: str) -> list[str]:
    """The local targets of links and pictures."""
    targets = [target or source for target, source in LINK.findall(text)]
    return [t for t in targets if not re.match(r"[a-z]+:|#", t)]


def broken_links(text: str, folder: Path) -> list[str]:
    return [t for t in links(text) if not (folder / t.split("#")[0]).exists()]


def test_tables_in_documents_are_those_of_the_results() -> None:
    script = ROOT / "scripts" / "insert_tables.py"
    run = subprocess.run(
        [sys.executable, script, "--check"], capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr


def test_the_figures_kept_are_those_that_documents_show() -> None:
    """Git ignores all others, as `report` rebuilds them."""
    ignore = (ROOT / ".gitignore").read_text(encoding="utf-8")
    exceptions = re.findall(r"^!/(results/\S+/figures/\S+)$", ignore, re.MULTILINE)
    shown = {
        (path.parent / target).resolve()
        for path in DOCUMENTS
        for target in links(path.read_text(encoding="utf-8"))
        if "/figures/" in target
    }
    assert {path for pattern in exceptions for path in ROOT.glob(pattern)} == shown != set()


def test_no_key_is_listed_twice() -> None:
    keys = ENTRY.findall((ROOT / "REFERENCES.md").read_text(encoding="utf-8"))
    assert len(keys) == len(set(keys)) > 0


@pytest.mark.parametrize(("document", "words"), commands_of("beltgrasp"))
def test_a_documented_command_line_is_accepted(
    parser: ModuleType, document: str, words: list[str]
) -> None:
    assert parser.run(words) == 0, f"{document}: beltgrasp {shlex.join(words)}"


@pytest.mark.parametrize(("document", "words"), commands_of("make"))
def test_a_documented_make_verb_exists(document: str, words: list[str]) -> None:
    verbs = {word for word in words if "=" not in word}
    assert verbs <= make_verbs(), document


def test_ci_runs_the_test_command_of_the_readme() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    commands = [line for line in command_lines(readme) if arguments(line, "make") is not None]
    assert {"make demo", "make test"} <= {shlex.join(shlex.split(c, True)) for c in commands}
    assert "\nmake test " in (ROOT / ".ci" / "run").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "line",
    [
        "trial --tracker igfp",
        "trial --speed 0.25",
        "trial --speed-mps fast",
        "trial --speed-mps -1",
        "sweep no-such-preset",
        "sweep",
        "reprot out/demo",
    ],
)
def test_a_wrong_command_line_is_refused(parser: ModuleType, line: str) -> None:
    assert parser.run(line.split()) != 0


def test_the_patterns_of_this_file_find_what_they_should() -> None:
    assert cited("as in [IGPF2021] Eq. (9) and [IGPFPatent]") == {"IGPF2021", "IGPFPatent"}
    assert cited("units [m], [px], [rad], list[Particles], a[i], [Link2020](x.md)") == set()
    assert list(docstrings('class A:\n    """One [Foo1999]."""\n    x: int = 0\n    """Two."""'))
    assert broken_links("[a](no_such.md) [b](https://example.org) [c](#x)", ROOT) == ["no_such.md"]
    assert broken_links('<img width="1" src="no.png">', ROOT) == ["no.png"]
    text = "```sh\n$ uv run beltgrasp trial \\\n  --seed 3  # three\nmake test\n```\n`make demo`"
    assert [arguments(line, "beltgrasp") for line in command_lines(text)] == [
        ["trial", "--seed", "3"],
        None,
        None,
    ]
    assert [arguments(line, "make") for line in command_lines(text)] == [None, ["test"], ["demo"]]
    assert {"demo", "test", "check"} <= make_verbs()
