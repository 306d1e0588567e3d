"""What the documents say holds: cited keys, paths, links, command lines and make verbs exist."""

from __future__ import annotations

import ast
import re
import shlex
import typing
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import insert_tables
import pytest
import structure

from experiments import cli
from experiments.belt.config import TrialConfig
from experiments.belt.presets import PRESETS
from experiments.belt.study import SweepTrial, trial_settings

ROOT = Path(__file__).resolve().parent.parent
HERE = Path(__file__).resolve()
CODE = ("sim", "tracker", "experiments", "assets", "benchmarks", "tests", "scripts")
DOCUMENTS = {
    path: path.read_text(encoding="utf-8")
    for pattern in ("*.md", ".github/**/*.md", "docs/**/*.md", "assets/**/*.md", "results/*.md")
    for path in sorted(ROOT.glob(pattern))
}
HISTORY = ROOT / "CHANGELOG.md"
"""Names files as they were called at the time."""
SOURCES = {
    path: path.read_text(encoding="utf-8")
    for folder in CODE
    for path in sorted((ROOT / folder).rglob("*.py"))
    if path != HERE  # gives wrong keys and paths as examples
}
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
PATH = re.compile(
    rf"`(?:python )?((?:{'|'.join(CODE)}|docs|results|\.ci)/[\w./*-]*|[\w*]+\.py)(?=[`\s:])"
)
PLACEHOLDER = re.compile(r"NAME|PRESET|STUDY")


def listed(found: Iterable[str]) -> str:
    """One offender a line, for a message."""
    return "".join(f"\n{line}" for line in found)


def places(texts: dict[Path, str], wrong: Callable[[str, Path], Iterable[str]]) -> list[str]:
    """File, line and what `wrong` finds in each line of the texts."""
    return [
        f"{path.relative_to(ROOT)}:{number}: {what}"
        for path, text in texts.items()
        for number, line in enumerate(text.splitlines(), 1)
        for what in wrong(line, path.parent)
    ]


def remarks(source: str) -> str:
    """The source without its code: strings that stand alone, as docstrings do, and comments."""
    lines = source.splitlines()
    kept = [match[0] if (match := re.search(r"#.*", line)) else "" for line in lines]
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            if isinstance(node.value.value, str):
                kept[node.lineno - 1 : node.end_lineno] = lines[node.lineno - 1 : node.end_lineno]
    return "\n".join(kept)


REMARKS = DOCUMENTS | {path: remarks(source) for path, source in SOURCES.items()}


def references() -> list[str]:
    return ENTRY.findall((ROOT / "REFERENCES.md").read_text(encoding="utf-8"))


def unknown_keys(text: str, known: Iterable[str]) -> list[str]:
    return [f"[{key}] is not in REFERENCES.md" for key in KEY.findall(text) if key not in known]


def links(text: str) -> list[str]:
    """The local targets of links and pictures."""
    targets = [target or source for target, source in LINK.findall(text)]
    return [t for t in targets if not re.match(r"[a-z]+:|#", t)]


def broken_links(text: str, folder: Path) -> list[str]:
    found = [t for t in links(text) if not (folder / t.split("#")[0]).exists()]
    return [f"the link to {target} leads nowhere" for target in found]


def missing_paths(text: str, folder: Path) -> list[str]:
    """Paths of the project in backticks that lead nowhere; a name alone may be anywhere."""
    paths = [path for path in PATH.findall(text) if not PLACEHOLDER.search(path)]
    return [f"there is no {path}" for path in paths if not _exists(path, folder)]


def _exists(path: str, folder: Path) -> bool:
    if "/" in path:
        return any(next(base.glob(path.rstrip("/")), None) for base in (ROOT, folder))
    return any(next((ROOT / top).rglob(path), None) for top in (*CODE, "docs"))


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


def commands_of(program: str) -> dict[tuple[str, ...], str]:
    """Each documented command line of `program`, with the first document that has it."""
    found: dict[tuple[str, ...], str] = {}
    for path, text in DOCUMENTS.items():
        for line in command_lines(text):
            if (words := arguments(line, program)) is not None:
                found.setdefault(tuple(words), path.relative_to(ROOT).as_posix())
    return found


def is_placeholder(name: str) -> bool:
    """`NAME`, `NAME-1` for a condition, or the import path of a reader's own tracker."""
    return name.rstrip("-0123456789").isupper() or ":" in name


def check(command: Any) -> int:
    """In place of running the command: whether the names that it was given exist."""
    if isinstance(config := getattr(command, "config", None), TrialConfig):
        named = "tracker embodiment camera object motion condition predictor".split()
        open_fields = [field for field in named if is_placeholder(getattr(config, field))]
        known = replace(config, **{f: getattr(TrialConfig(), f) for f in open_fields})
        trial_settings(SweepTrial("trial", known))
    preset = getattr(command, "preset", None)
    return 0 if preset is None or preset in PRESETS or is_placeholder(preset) else 1


@pytest.fixture
def parser(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The command line, of which each command checks its names instead of running."""
    for choice in typing.get_args(cli.Command):
        monkeypatch.setattr(typing.get_args(choice)[0], "run", check)
    return cli


def test_cited_keys_are_in_references() -> None:
    known = references()
    wrong = places(REMARKS, lambda line, _: unknown_keys(line, known))
    assert not wrong, listed(wrong)


def test_no_key_is_listed_twice() -> None:
    assert len(references()) == len(set(references())) > 0


def test_links_lead_somewhere() -> None:
    wrong = places(DOCUMENTS, broken_links)
    assert not wrong, listed(wrong)


def test_paths_that_are_named_exist() -> None:
    wrong = places({path: t for path, t in REMARKS.items() if path != HISTORY}, missing_paths)
    assert not wrong, listed(wrong)


def test_contributing_has_a_line_for_every_folder_of_the_packages() -> None:
    lines = re.findall(r"^\| `([\w/]+)/` \|", DOCUMENTS[ROOT / "CONTRIBUTING.md"], re.MULTILINE)
    rooms = {structure.room(module).replace(".", "/") for module in structure.sources()} - {""}
    folders = {room for room in rooms if (ROOT / room).is_dir()}
    assert folders and folders <= set(lines)


def test_tables_in_documents_are_those_of_the_results() -> None:
    assert not insert_tables.stale()


def test_of_a_long_table_the_chosen_rows_are_shown_and_all_are_linked() -> None:
    table = (ROOT / "results/loop/tables/success.md").read_text(encoding="utf-8").splitlines(True)
    path, where = "results/loop/tables/success.md", "tracker = igpf; speed [m/s] = 0.10, 1.00"
    text = f"a\n<!-- {path} where {where} -->\nold\n<!-- end -->\nb"
    shown = insert_tables.refreshed(text, ROOT / "docs")
    igpf = [row for row in table if row.startswith("| igpf |")]
    rows = "".join([*table[:2], *(r for r in igpf if re.search(r"normal \| (0\.1|1\.0)0", r))])
    assert rows.count("\n") == 4
    assert shown == (
        f"a\n<!-- {path} where {where} -->\n\n{rows}\n[All 10 rows](../{path})\n\n<!-- end -->\nb"
    )
    assert insert_tables.refreshed(shown, ROOT / "docs") == shown
    whole = insert_tables.refreshed(f"<!-- {path} -->\nold\n<!-- end -->")
    assert whole == f"<!-- {path} -->\n\n{''.join(table)}\n<!-- end -->"
    with pytest.raises(ValueError, match=r"column must be one of tracker, .*; got 'trackers'"):
        insert_tables.selected("".join(table), "trackers = igpf")
    with pytest.raises(ValueError, match="no row has tracker = none"):
        insert_tables.selected("".join(table), "tracker = igpf, none")


def test_the_figures_kept_are_those_that_documents_show() -> None:
    """Git ignores all others, as `report` rebuilds them."""
    ignore = (ROOT / ".gitignore").read_text(encoding="utf-8")
    exceptions = re.findall(r"^!/(results/\S+/figures/\S+)$", ignore, re.MULTILINE)
    shown = {
        (path.parent / target).resolve()
        for path, text in DOCUMENTS.items()
        for target in links(text)
        if "/figures/" in target
    }
    assert {path for pattern in exceptions for path in ROOT.glob(pattern)} == shown != set()


def test_documented_command_lines_are_accepted(
    parser: ModuleType, capsys: pytest.CaptureFixture[str]
) -> None:
    wrong = [
        f"{document}: beltgrasp {shlex.join(words)}: {capsys.readouterr().err.strip()}"
        for words, document in commands_of("beltgrasp").items()
        if parser.run(words) != 0
    ]
    assert not wrong, listed(wrong)


def test_documented_make_verbs_exist() -> None:
    verbs = make_verbs()
    wrong = [
        f"{document}: make {word}"
        for words, document in commands_of("make").items()
        for word in words
        if "=" not in word and word not in verbs
    ]
    assert not wrong, listed(wrong)


def test_ci_runs_the_checks_and_the_test_command_of_the_readme() -> None:
    readme = command_lines(DOCUMENTS[ROOT / "README.md"])
    commands = [line for line in readme if arguments(line, "make") is not None]
    assert {"make demo", "make test"} <= {shlex.join(shlex.split(c, True)) for c in commands}
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert script.index("\nmake check ") < script.index("\nmake test ")


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
    assert KEY.findall("as in [IGPF2021] Eq. (9) and [IGPFPatent]") == ["IGPF2021", "IGPFPatent"]
    assert not KEY.findall("units [m], [px], [rad], list[Particles], a[i], [Link2020](x.md)")
    assert unknown_keys("[IGPF2021], [Foo1999]", references()) == [
        "[Foo1999] is not in REFERENCES.md"
    ]
    source = 'class A:\n    """One [Foo1999].\n    """\n    x: int = 0  # [Bar1999]\n    "Two."'
    assert remarks(source) == '\n    """One [Foo1999].\n    """\n# [Bar1999]\n    "Two."'
    text = '[a](no_such.md) [b](https://example.org) [c](#x) [d](README.md#x)\n<img src="no.png">'
    assert broken_links(text, ROOT) == [
        "the link to no_such.md leads nowhere",
        "the link to no.png leads nowhere",
    ]
    assert places({ROOT / "a" / "b.md": "ok\n[a](README.md)"}, broken_links) == [
        "a/b.md:2: the link to README.md leads nowhere"
    ]


def test_a_path_that_leads_nowhere_is_found() -> None:
    wrong = "`sim/none.py` `tests/no/test_x.py` `none.py` `python scripts/none.py` `results/x/`"
    assert missing_paths(wrong, ROOT) == [
        f"there is no {path}"
        for path in (
            "sim/none.py",
            "tests/no/test_x.py",
            "none.py",
            "scripts/none.py",
            "results/x/",
        )
    ]
    right = "`sim/` `tests/test_docs.py` `test_docs.py` `scripts/*.py --check` `assets/NAME.xml`"
    assert not missing_paths(f"{right} `sim.belt` `out/x.mp4` `results/loop/rows.csv`", ROOT)


def test_command_lines_are_found() -> None:
    text = "```sh\n$ uv run beltgrasp trial \\\n  --seed 3  # three\nmake test\n```\n`make demo`"
    assert [arguments(line, "beltgrasp") for line in command_lines(text)] == [
        ["trial", "--seed", "3"],
        None,
        None,
    ]
    assert [arguments(line, "make") for line in command_lines(text)] == [None, ["test"], ["demo"]]
    assert {"demo", "test", "check"} <= make_verbs()
    assert ("list",) in commands_of("beltgrasp")
