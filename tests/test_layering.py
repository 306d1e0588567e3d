"""Which module may import what, where randomness may come from, and who may see the ground truth.

`sim` and `tracker` know nothing of each other or of `experiments`, and `tracker` knows nothing of
the simulator. A tracker, the servo and the grasp therefore see images, estimates and joint angles
only: what the simulator knows of the object (the truth) lives in `sim.belt.task`,
`sim.belt.environment` and `sim.belt.referee`; `experiments/belt/cell.py` reads it out. Where it and
a tracker are in one module:
- `experiments/belt/teaching.py` lays the object on the still belt before any trial and takes the
  reference photograph, from which the template is cut that `experiments/belt/cell.py` keeps;
- `experiments/belt/perception.py` holds the oracles beside the trackers;
- `experiments/belt/loop.py` runs perception and writes the truth into the trace, for scoring;
- `experiments/bearing_only/flying.py` is the loop of the bearing-only flights, whose truth lives in
  `sim.bearing_only.flight`; beside it `oracles.py` holds their oracles, `senses.py` and
  `image_senses.py` turn the world into measurements, and `top_view.py` draws truth and belief for
  a film;
- `experiments/apple/replay.py` hangs the fruit up, and scores what the methods say of its images.
"""

from __future__ import annotations

import ast
import functools
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("sim", "tracker", "experiments")
SIMULATORS = {"mujoco", "dm_control", "dm_env", "mink", "glfw"}
FORBIDDEN_ROOTS = {
    "sim": {"tracker", "experiments"},
    "tracker": {"sim", "experiments"} | SIMULATORS,
    "experiments": set[str](),
}
TRUTH_MODULES = {
    "sim.belt.task",
    "sim.belt.environment",
    "sim.belt.referee",
    "sim.bearing_only.flight",
    "sim.apple.fruit",
    "experiments.belt.cell",
}
BLIND_MODULES = ("sim.arm.servo", "sim.arm.grasp")
TRACKER_VOCABULARY = {"tracker.base"}  # types that say how a track stands; nothing to tell truth to
TRUTH_MEETS_TRACKER = {
    f"experiments.{name}"
    for name in (
        "belt.cell",
        "belt.loop",
        "belt.perception",
        "belt.teaching",
        "apple.replay",
        "bearing_only.flying",
        "bearing_only.image_senses",
        "bearing_only.oracles",
        "bearing_only.senses",
        "bearing_only.top_view",
    )
}
SEEDING = "experiments.seeding"
SEEDED = {"Generator", "BitGenerator", "SeedSequence", "PCG64", "PCG64DXSM", "MT19937", "Philox"}


def module_name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


SOURCES = {
    module_name(path): path.read_text(encoding="utf-8")
    for package in PACKAGES
    for path in sorted((ROOT / package).rglob("*.py"))
}


@functools.cache
def imported(source: str, module: str) -> frozenset[str]:
    """Every dotted name that `module` imports, `from a import b` giving both a and a.b."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            package = module.split(".")[: -node.level] if node.level else []
            base = ".".join([*package, *([node.module] if node.module else [])])
            names.update({base} | {f"{base}.{alias.name}" for alias in node.names})
        elif isinstance(node, ast.Call) and dotted(node.func).split(".")[-1] in (
            "import_module",
            "__import__",
        ):
            names.update(a.value for a in node.args if isinstance(a, ast.Constant))
    return frozenset(names)


def dotted(node: ast.AST) -> str:
    """`a.b.c` of an attribute chain, else an empty string."""
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute):
        return f"{base}.{node.attr}" if (base := dotted(node.value)) else ""
    return ""


def forbidden_imports(source: str, module: str) -> set[str]:
    forbidden = FORBIDDEN_ROOTS[module.split(".")[0]]
    return {name for name in imported(source, module) if name.split(".")[0] in forbidden}


def _annotations(tree: ast.AST) -> Iterator[ast.AST]:
    for node in ast.walk(tree):
        for field in ("annotation", "returns"):
            if (annotation := getattr(node, field, None)) is not None:
                yield from ast.walk(annotation)


def _aliases(tree: ast.AST) -> dict[str, str]:
    """Local name -> dotted name of what was imported under it."""
    aliases: dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                root = alias.name.split(".")[0]
                aliases[alias.asname or root] = alias.name if alias.asname else root
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            for alias in node.names:
                aliases[alias.asname or alias.name] = f"{node.module}.{alias.name}"
    return aliases


def hidden_randomness(source: str) -> set[str]:
    """Uses of random streams that no seed of ours reaches; the type RandomState may be named."""
    tree = ast.parse(source)
    aliases, in_annotation = _aliases(tree), {id(node) for node in _annotations(tree)}
    seeded_calls = {
        id(node.func)
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and (node.args or node.keywords)
    }
    found = {f"import {name}" for name in aliases.values() if name.split(".")[0] == "random"}
    for node in ast.walk(tree):
        root, _, rest = dotted(node).partition(".")
        name = ".".join(filter(None, [aliases.get(root, root), rest]))
        if not name.startswith("numpy.random.") or name.removeprefix("numpy.random.") in SEEDED:
            continue
        if name == "numpy.random.RandomState" and id(node) in in_annotation:
            continue
        if name == "numpy.random.default_rng" and id(node) in seeded_calls:
            continue
        found.add(name)
    return found


def truth_names(tree: ast.AST) -> set[str]:
    """Variables, attributes and parameters of which the word truth is a part."""
    names = {
        getattr(node, field)
        for node in ast.walk(tree)
        for field in ("id", "attr", "arg")
        if isinstance(getattr(node, field, None), str)
    }
    return {name for name in names if "truth" in name.lower().split("_")}


def reachable(module: str, sources: dict[str, str]) -> set[str]:
    """The project's modules that importing `module` imports, itself among them."""
    seen: set[str] = set()
    waiting = [module]
    while waiting:
        name = waiting.pop()
        if name in sources and name not in seen:
            seen.add(name)
            waiting.extend(imported(sources[name], name))
    return seen


def is_blind(module: str) -> bool:
    return module in BLIND_MODULES or module.split(".")[0] == "tracker"


def crossings(sources: dict[str, str]) -> set[str]:
    """Modules that import the truth and more of a tracker than its vocabulary."""
    found: set[str] = set()
    for module, source in sources.items():
        names = imported(source, module)
        parts = {".".join(name.split(".")[:2]) for name in names if name.startswith("tracker.")}
        if names & TRUTH_MODULES and parts - TRACKER_VOCABULARY:
            found.add(module)
    return found


def test_the_modules_of_this_file_exist() -> None:
    assert {*TRUTH_MODULES, *BLIND_MODULES, *TRUTH_MEETS_TRACKER, SEEDING} <= set(SOURCES)


@pytest.mark.parametrize("module", SOURCES)
def test_imports_point_one_way(module: str) -> None:
    assert not forbidden_imports(SOURCES[module], module)


@pytest.mark.parametrize("module", [name for name in SOURCES if name != SEEDING])
def test_all_randomness_comes_from_an_explicit_seed(module: str) -> None:
    assert not hidden_randomness(SOURCES[module])


@pytest.mark.parametrize("module", [name for name in SOURCES if is_blind(name)])
def test_control_never_reaches_the_truth(module: str) -> None:
    assert not reachable(module, SOURCES) & TRUTH_MODULES
    assert not truth_names(ast.parse(SOURCES[module]))


def test_truth_meets_a_tracker_in_plain_sight_only() -> None:
    assert crossings(SOURCES) <= TRUTH_MEETS_TRACKER


def test_the_perception_of_a_tracker_names_no_truth() -> None:
    """The oracles stand beside it in the same module; they alone may read the truth."""
    tree = ast.parse(SOURCES["experiments.belt.perception"])
    classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
    seeing = {name: truth_names(node) for name, node in classes.items() if "Oracle" not in name}
    assert "Seeing" in seeing
    assert not any(seeing.values())


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("sim.imaging.camera", "import tracker.affine.aff2"),
        ("sim.imaging.camera", "from experiments import config"),
        ("tracker.pf", "import mujoco as m"),
        ("tracker.pf", "def late():\n    from dm_control import mjcf"),
        ("tracker.pf", "import importlib\nimportlib.import_module('sim.imaging.camera')"),
    ],
)
def test_a_wrong_import_is_found(module: str, source: str) -> None:
    assert forbidden_imports(source, module)


def test_relative_imports_stay_in_their_package() -> None:
    assert imported("from . import aff2\nfrom .weights import ess", "tracker.pf") >= {
        "tracker.aff2",
        "tracker.weights",
    }


@pytest.mark.parametrize(
    "source",
    [
        "import numpy as np\nnp.random.seed(0)",
        "import numpy as np\nx = np.random.normal(size=3)",
        "import numpy\nnumpy.random.RandomState(3)",
        "import numpy as np\nrng = np.random.default_rng()",
        "from numpy.random import rand\nrand(3)",
        "from numpy import random\nrandom.shuffle([])",
        "import numpy.random as npr\nnpr.choice(3)",
        "import random",
        "from random import choice",
    ],
)
def test_hidden_randomness_is_found(source: str) -> None:
    assert hidden_randomness(source)


@pytest.mark.parametrize(
    "source",
    [
        "import numpy as np\nrng = np.random.default_rng(seed)",
        "import numpy as np\ndef f(s: np.random.RandomState | None, g: np.random.Generator): ...",
        "def f(rng):\n    return rng.random.normal()",
    ],
)
def test_explicit_randomness_is_let_through(source: str) -> None:
    assert not hidden_randomness(source)


def test_a_way_to_the_truth_is_found() -> None:
    sources = {
        "sim.arm.grasp": "from sim import a",
        "sim.a": "import sim.belt.task",
        "sim.belt.task": "",
    }
    assert "sim.belt.task" in reachable("sim.arm.grasp", sources)
    assert truth_names(ast.parse("pose = self._cell.read_truth()")) == {"read_truth"}
    assert truth_names(ast.parse("def step(ground_truth): ...")) == {"ground_truth"}
    assert crossings({"experiments.x": "import sim.belt.task\nfrom tracker import pf"})
    assert not crossings({"experiments.x": "import sim.belt.task\nfrom tracker.base import Status"})
