"""Prints how the packages are built: the rooms of each, who imports whom, and circles.

    python scripts/structure.py [CHECKOUT]

A room is a folder or a file directly under `sim`, `tracker` or `experiments`. An arrow leads from a
room to another one of the same package that it imports from. `tests/test_layering.py` holds the
numbers to their bounds.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("sim", "tracker", "experiments")


def sources(root: Path = ROOT) -> dict[str, str]:
    """The source of every module, by its dotted name."""
    return {
        ".".join(path.relative_to(root).with_suffix("").parts).removesuffix(".__init__"): (
            path.read_text(encoding="utf-8")
        )
        for package in PACKAGES
        for path in sorted((root / package).rglob("*.py"))
    }


def imports(source: str, module: str) -> Iterator[tuple[int, str]]:
    """Line and dotted name of every import of `module`; `from a import b` gives both a and a.b."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            package = module.split(".")[: -node.level] if node.level else []
            base = ".".join([*package, *([node.module] if node.module else [])])
            yield node.lineno, base
            yield from ((node.lineno, f"{base}.{alias.name}") for alias in node.names)
        elif isinstance(node, ast.Call) and dotted(node.func).split(".")[-1] in (
            "import_module",
            "__import__",
        ):
            yield from ((node.lineno, a.value) for a in node.args if isinstance(a, ast.Constant))


def dotted(node: ast.AST) -> str:
    """`a.b.c` of an attribute chain, else an empty string."""
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute):
        return f"{base}.{node.attr}" if (base := dotted(node.value)) else ""
    return ""


def room(module: str) -> str:
    """`tracker.belt` of `tracker.belt.detection`; empty for a package, which is in no room."""
    parts = module.split(".")
    return ".".join(parts[:2]) if parts[0] in PACKAGES and len(parts) > 1 else ""


def foreign_rooms(modules: dict[str, str]) -> dict[str, set[str]]:
    """The rooms, other than its own and of all packages, from which each module imports."""
    names = set(map(room, modules)) - {""}
    return {
        module: {room(name) for _, name in imports(source, module)} & names - {room(module)}
        for module, source in modules.items()
    }


def arrows(foreign: dict[str, set[str]], package: str) -> dict[str, set[str]]:
    """Each room of the package, with the other rooms of the package that it imports from."""
    found: dict[str, set[str]] = {}
    for module, names in foreign.items():
        if (own := room(module)).startswith(f"{package}."):
            inside = {name for name in names if name.startswith(f"{package}.")}
            found[own] = found.get(own, set()) | inside
    return dict(sorted(found.items()))


def circles(found: dict[str, set[str]]) -> list[list[str]]:
    """The largest groups of rooms each of which reaches all others of its group."""
    reached = {name: _reachable(name, found) for name in found}
    groups = {frozenset(b for b in reached[a] if a in reached[b]) for a in found}
    return sorted(sorted(group) for group in groups if len(group) > 1)


def _reachable(start: str, found: dict[str, set[str]]) -> set[str]:
    seen: set[str] = set()
    waiting = [start]
    while waiting:
        new = found[waiting.pop()] - seen
        seen |= new
        waiting.extend(new)
    return seen


def main() -> None:
    """Prints the structure of the given checkout, or of this one."""
    modules = sources(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT)
    foreign = foreign_rooms(modules)
    for package in PACKAGES:
        found = arrows(foreign, package)
        lines = sum(
            source.count("\n") for name, source in modules.items() if name.split(".")[0] == package
        )
        count = sum(map(len, found.values()))
        print(f"{package}: {lines} lines, {len(found)} rooms, {count} arrows")
        for name, targets in found.items():
            print(f"  {name.split('.')[1]:<16}{' '.join(t.split('.')[1] for t in sorted(targets))}")
        for circle in circles(found):
            print("  circle: " + " ".join(name.split(".")[1] for name in circle))


if __name__ == "__main__":
    main()
