"""The recipes of CONTRIBUTING.md, followed to the letter: rows, files and commands as they stand.

A row is evaluated where it is to be added, with what the module imports and nothing else. The files
go into a copy of the assets.
"""

from __future__ import annotations

import importlib.util
import inspect
import re
import shlex
import shutil
import sys
import textwrap
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import experiments
from experiments import cli, studies
from experiments.catalogue import catalogue
from experiments.study.run import run
from sim.imaging.degradations import get_condition

ROOT = Path(__file__).resolve().parent.parent
BLOCK = re.compile(r"^( *)```(\w+)\n(.*?)^\1```", re.MULTILINE | re.DOTALL)
COMMAND = re.compile(r"`beltgrasp ([^`\n]+)`")
PLACE = re.compile(r"Add a row to `([A-Z]+)` in `([\w/]+)\.py`")


def recipe(title: str) -> str:
    """The section of that title."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    return text.split(f"## {title}\n")[1].split("\n## ")[0]


def block(section: str, language: str) -> str:
    """The section's only block in that language."""
    (found,) = [body for _, kind, body in BLOCK.findall(section) if kind == language]
    return textwrap.dedent(found)


@pytest.fixture(autouse=True)
def fresh_catalogue():
    """`list` reads the registries once in a process."""
    catalogue.cache_clear()
    yield
    catalogue.cache_clear()


def add_row(section: str, monkeypatch: pytest.MonkeyPatch) -> tuple[str, Any]:
    """Adds the section's row to the registry that it names; the row's name and entry."""
    registry, path = PLACE.findall(section)[0]
    module = importlib.import_module(path.replace("/", "."))
    ((name, entry),) = eval("{" + block(section, "python") + "}", vars(module)).items()
    assert name not in getattr(module, registry)
    monkeypatch.setitem(getattr(module, registry), name, entry)
    return name, entry


@pytest.fixture(params=["quick", pytest.param("all", marks=pytest.mark.slow)])
def commands(request) -> re.Pattern[str]:
    """Which commands to run; quick ones render nothing."""
    return re.compile("list$|.*oracle$" if request.param == "quick" else "")


def run_commands(
    section: str, name: str, commands: re.Pattern[str], capsys: pytest.CaptureFixture[str]
) -> None:
    """Runs the section's commands, with the name for NAME; each ends well."""
    wanted = [c for c in COMMAND.findall(section) if commands.match(c)]
    assert wanted[0] == "list"
    for command in wanted:
        capsys.readouterr()
        assert cli.run(shlex.split(command.replace("NAME", name))) == 0, command
        printed = capsys.readouterr().out
        assert re.search(rf"\b{name}\b" if command == "list" else r"\bsuccess\b", printed), command


def test_add_a_tracker(monkeypatch, commands, capsys):
    section = recipe("Add a tracker")
    name, _ = add_row(section, monkeypatch)
    run_commands(section, name, commands, capsys)


def test_add_a_condition(monkeypatch, commands, capsys, tmp_path):
    section = recipe("Add a condition")
    monkeypatch.chdir(tmp_path)
    name, _ = add_row(section, monkeypatch)
    assert get_condition(f"{name}-1") != get_condition(f"{name}-0")
    run_commands(section, name, commands, capsys)
    assert (tmp_path / "out" / "look.mp4").is_file() or not commands.match("trial")


def test_add_an_object(monkeypatch, commands, capsys, tmp_path):
    section = recipe("Add an object")
    shutil.copytree(ROOT / "assets", tmp_path / "assets")
    name, spec = add_row(section, monkeypatch)
    (path,) = re.findall(r"^1\. Write `([^`]+)`", section.strip(), re.MULTILINE)
    (tmp_path / path.replace("NAME", name)).write_text(block(section, "xml"), encoding="utf-8")
    with (tmp_path / "assets" / "PROVENANCE.md").open("a", encoding="utf-8") as provenance:
        provenance.write(block(section, "text"))
    tests = module_of("tests/sim/belt/test_objects.py")
    for module in (tests, importlib.import_module("sim.belt.objects")):
        monkeypatch.setattr(module, "ASSETS", tmp_path / "assets")
    ran = 0
    for title, test in vars(tests).items():
        if title.startswith("test_") and list(inspect.signature(test).parameters) == ["spec"]:
            test(spec)
            ran += 1
    assert ran >= 5
    run_commands(section, name, commands, capsys)


def module_of(path: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(Path(path).stem + "_of_recipe", ROOT / path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class ThisProcess:
    """Does the work here: a new process would not find a study that stands in a test's folder."""

    count = 1

    def run_all(self, work, tasks):
        yield from map(work, tasks)


def test_add_a_study(monkeypatch, tmp_path, capsys):
    section = recipe("Add a study")
    path = tmp_path / "experiments" / "readings"
    path.mkdir(parents=True)
    (path / "__init__.py").write_text("")
    (path / "study.py").write_text(block(section, "python"), encoding="utf-8")
    monkeypatch.setattr(experiments, "__path__", [*experiments.__path__, str(path.parent)])
    ((name, module),) = eval("{" + block(section, "text") + "}").items()
    monkeypatch.setitem(studies.SUBJECTS, name, module)
    command = importlib.import_module(module).ReadingsCommand
    out = tmp_path / "out"
    plan = command(seeds=5, out=out)._plan
    run(plan.study, plan.selection, out, ThisProcess())
    assert cli.run(["report", str(out)]) == 0
    assert "error [m]" in capsys.readouterr().out
    assert cli.run(["compare", f"{out}:median", f"{out}:mean"]) == 0
    assert "median" in capsys.readouterr().out
    sys.modules.pop(module)
