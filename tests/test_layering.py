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
  `sim.bearing_only.flight`; beside it `oracles.py` holds their oracles, `sensor_models.py`
  turns the world into measurements, and `top_view.py` draws truth and belief for a film;
- `experiments/apple/replay.py` hangs the fruit up, and scores what the methods say of its images.

Each package has rooms: the folders and files directly under it (`scripts/structure.py` prints
them). Four subjects have a room in each package and do not know each other; what they share is in
other rooms, which know no subject. Only the command line and the catalogue know all of them.
"""

from __future__ import annotations

import ast
import functools
from collections.abc import Iterable, Iterator

import pytest
import structure

PACKAGES = structure.PACKAGES
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
TRACKER_VOCABULARY = {"tracker.base", "tracker.checks"}  # no part of a tracker to tell truth to
TRUTH_MEETS_TRACKER = {
    f"experiments.{name}"
    for name in (
        "belt.cell",
        "belt.loop",
        "belt.perception",
        "belt.teaching",
        "apple.replay",
        "bearing_only.flying",
        "bearing_only.oracles",
        "bearing_only.sensor_models",
        "bearing_only.top_view",
    )
}
SEEDING = "experiments.seeding"
SEEDED = {"Generator", "BitGenerator", "SeedSequence", "PCG64", "PCG64DXSM", "MT19937", "Philox"}

SUBJECTS = {"belt", "video", "apple", "bearing_only"}
ASSEMBLERS = {"experiments.cli", "experiments.catalogue"}
"""Rooms that know all subjects, so that a user finds them in one place."""
ROOMS_AT_MOST = {"sim": 10, "tracker": 12, "experiments": 10}
ARROWS_AT_MOST = {"sim": 24, "tracker": 24, "experiments": 30}
"""Between the rooms of a package; experiments had 201 when its modules stood on one level."""

SOURCES = structure.sources()
FOREIGN = structure.foreign_rooms(SOURCES)


@functools.cache
def imported(source: str, module: str) -> frozenset[str]:
    return frozenset(name for _, name in structure.imports(source, module))


def forbidden_imports(source: str, module: str) -> Iterator[tuple[int, str]]:
    forbidden = FORBIDDEN_ROOTS[module.split(".")[0]]
    for line, name in structure.imports(source, module):
        if name.split(".")[0] in forbidden:
            yield line, f"imports {name}"


def _annotations(tree: ast.AST) -> Iterator[ast.AST]:
    for node in ast.walk(tree):
        for field in ("annotation", "returns"):
            if (annotation := getattr(node, field, None)) is not None:
                yield from ast.walk(annotation)


def _aliases(tree: ast.AST) -> dict[str, tuple[int, str]]:
    """Local name -> line and dotted name of what was imported under it."""
    aliases: dict[str, tuple[int, str]] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                root = alias.name.split(".")[0]
                aliases[alias.asname or root] = node.lineno, alias.name if alias.asname else root
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            for alias in node.names:
                aliases[alias.asname or alias.name] = node.lineno, f"{node.module}.{alias.name}"
    return aliases


def hidden_randomness(source: str) -> Iterator[tuple[int, str]]:
    """Uses of random streams that no seed of ours reaches; the type RandomState may be named."""
    if "random" not in source:
        return
    tree = ast.parse(source)
    aliases, in_annotation = _aliases(tree), {id(node) for node in _annotations(tree)}
    seeded_calls = {
        id(node.func)
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and (node.args or node.keywords)
    }
    for line, name in aliases.values():
        if name.split(".")[0] == "random":
            yield line, f"imports {name}"
    for node in ast.walk(tree):
        root, _, rest = structure.dotted(node).partition(".")
        name = ".".join(filter(None, [aliases.get(root, (0, root))[1], rest]))
        if not name.startswith("numpy.random.") or name.removeprefix("numpy.random.") in SEEDED:
            continue
        if name == "numpy.random.RandomState" and id(node) in in_annotation:
            continue
        if name == "numpy.random.default_rng" and id(node) in seeded_calls:
            continue
        yield node.lineno, f"uses {name}"


def truth_names(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Variables, attributes and parameters of which the word truth is a part."""
    for node in ast.walk(tree):
        for field in ("id", "attr", "arg"):
            name = getattr(node, field, None)
            if isinstance(name, str) and "truth" in name.lower().split("_"):
                yield node.lineno, f"names {name}"


def ways_to_truth(module: str, sources: dict[str, str]) -> Iterator[str]:
    """For each module of the truth that importing `module` imports, a shortest way to it."""
    ways = {module: module}
    waiting = [module]
    for name in waiting:
        for found in sorted(imported(sources[name], name) - ways.keys()):
            if found in sources:
                ways[found] = f"{ways[name]} -> {found}"
                waiting.append(found)
    return (way for name, way in ways.items() if name in TRUTH_MODULES)


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


def subject(room: str) -> str:
    """The subject of `tracker.belt` is `belt`; of `tracker.affine`, none."""
    name = room.partition(".")[2]
    return name if name in SUBJECTS else ""


def wrong_rooms(foreign: dict[str, set[str]]) -> Iterator[str]:
    """Imports of one subject from another, and of a subject from what all share."""
    for module, rooms in foreign.items():
        own = structure.room(module)
        if own not in ASSEMBLERS:
            for name in sorted(rooms):
                if subject(name) not in ("", subject(own)):
                    yield f"{module} knows {name}"


def listed(found: Iterable[str]) -> str:
    """One offender a line, for a message; empty if there is none."""
    return "".join(f"\n{line}" for line in found)


def places(module: str, found: Iterable[tuple[int, str]]) -> Iterator[str]:
    return (f"{module}, line {line}: {what}" for line, what in found)


def test_the_modules_of_this_file_exist() -> None:
    assert {*TRUTH_MODULES, *BLIND_MODULES, *TRUTH_MEETS_TRACKER, SEEDING} <= set(SOURCES)
    assert set(FOREIGN) >= ASSEMBLERS


def test_imports_point_one_way() -> None:
    wrong = [
        place for m, source in SOURCES.items() for place in places(m, forbidden_imports(source, m))
    ]
    assert not wrong, listed(wrong)


def test_all_randomness_comes_from_an_explicit_seed() -> None:
    wrong = [
        place
        for module, source in SOURCES.items()
        if module != SEEDING
        for place in places(module, hidden_randomness(source))
    ]
    assert not wrong, listed(wrong)


def test_control_never_reaches_the_truth() -> None:
    blind = [module for module in SOURCES if is_blind(module)]
    wrong = [way for module in blind for way in ways_to_truth(module, SOURCES)]
    wrong += [place for m in blind for place in places(m, truth_names(ast.parse(SOURCES[m])))]
    assert len(blind) > len(BLIND_MODULES)
    assert not wrong, listed(wrong)


def test_truth_meets_a_tracker_in_plain_sight_only() -> None:
    assert crossings(SOURCES) <= TRUTH_MEETS_TRACKER


def test_the_perception_of_a_tracker_names_no_truth() -> None:
    """The oracles stand beside it in the same module; they alone may read the truth."""
    tree = ast.parse(SOURCES["experiments.belt.perception"])
    classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
    seeing = {
        name: set(truth_names(node)) for name, node in classes.items() if "Oracle" not in name
    }
    assert "Seeing" in seeing
    assert not any(seeing.values())


def test_subjects_do_not_know_each_other_and_nobody_else_knows_them() -> None:
    wrong = list(wrong_rooms(FOREIGN))
    assert not wrong, listed(wrong)


def test_rooms_are_few_and_their_imports_make_no_circle() -> None:
    found = {package: structure.arrows(FOREIGN, package) for package in PACKAGES}
    crowded = {
        package: sorted(a) for package, a in found.items() if len(a) > ROOMS_AT_MOST[package]
    }
    assert not crowded
    assert not [circle for arrows in found.values() for circle in structure.circles(arrows)]
    counts = {package: sum(map(len, arrows.values())) for package, arrows in found.items()}
    many = {package: n for package, n in counts.items() if n > ARROWS_AT_MOST[package]}
    assert not many, "`python scripts/structure.py` prints them"


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
    assert [line for line, _ in forbidden_imports(source, module)][:1] == [source.count("\n") + 1]


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
    assert list(hidden_randomness(source))


@pytest.mark.parametrize(
    "source",
    [
        "import numpy as np\nrng = np.random.default_rng(seed)",
        "import numpy as np\ndef f(s: np.random.RandomState | None, g: np.random.Generator): ...",
        "def f(rng):\n    return rng.random.normal()",
    ],
)
def test_explicit_randomness_is_let_through(source: str) -> None:
    assert not list(hidden_randomness(source))


def test_a_way_to_the_truth_is_found() -> None:
    sources = {
        "sim.arm.grasp": "from sim import a",
        "sim.a": "import sim.belt.task",
        "sim.belt.task": "",
    }
    assert list(ways_to_truth("sim.arm.grasp", sources)) == [
        "sim.arm.grasp -> sim.a -> sim.belt.task"
    ]
    assert list(truth_names(ast.parse("pose = 1\npose = self._cell.read_truth()"))) == [
        (2, "names read_truth")
    ]
    assert list(truth_names(ast.parse("def step(ground_truth): ...")))
    assert crossings({"experiments.x": "import sim.belt.task\nfrom tracker import pf"})
    assert not crossings({"experiments.x": "import sim.belt.task\nfrom tracker.base import Status"})


def test_subjects_that_know_each_other_are_found() -> None:
    sources = {
        "tracker.belt.a": "from tracker.video import b\nfrom tracker.peers import c",
        "tracker.video.b": "import tracker.video.d\nimport tracker.affine",
        "tracker.peers.c": "def late():\n    from ..belt import a",
        "experiments.video": "from sim.belt.e import F\nfrom experiments import __version__",
        "experiments.cli": "import experiments.video",
        "sim.belt.e": "from sim import ASSETS",
        "sim": "",
    }
    foreign = structure.foreign_rooms(sources)
    assert list(wrong_rooms(foreign)) == [
        "tracker.belt.a knows tracker.video",
        "tracker.peers.c knows tracker.belt",
        "experiments.video knows sim.belt",
    ]
    arrows = structure.arrows(foreign, "tracker")
    assert arrows == {
        "tracker.belt": {"tracker.video", "tracker.peers"},
        "tracker.peers": {"tracker.belt"},
        "tracker.video": set(),
    }
    assert structure.circles(arrows) == [["tracker.belt", "tracker.peers"]]
