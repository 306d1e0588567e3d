"""Trackers from outside this repository, named by import path: `my_package.my_module:MyTracker`.

Such a class is made with a `numpy.random.Generator` and has two methods:

    start(image, box)    image (h, w, 3) uint8 BGR; box (4,) x, y, w, h [px], whole pixels
    find(image)          the box in the next image, four numbers, or None where it is not found

`find` may also return a `tracker.box_tracker.BoxEstimate`, if it knows a warp. In the conveyor
loop the images are the overhead ones, and detection and reconstruction are those of every tracker.
"""

import contextlib
import importlib
import inspect
import sys
from modulefinder import ModuleFinder
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from tracker.box_tracker import BoxEstimate
from tracker.checks import require_known
from tracker.peers.baselines import BASELINES, Baseline

_THIS_PROJECT = ("sim", "tracker", "experiments")
_LOADED_SOURCE = "__source_when_loaded__"
"""Attribute of a loaded module by which an edit of its source is noticed."""


def is_outside(name: str) -> bool:
    """Whether a tracker's name is an import path."""
    return ":" in name


def get_box_finder(name: str) -> Baseline:
    """The baseline of that name, or the class at that import path.

    Raises ValueError that says what is wrong with the path or the class. The working folder counts
    as a place for modules, as it does for `python -m`.
    """
    if not is_outside(name):
        require_known("tracker", name, BASELINES)
        return BASELINES[name]
    found = _load(name)
    return Baseline(f"{name}, from outside", lambda rng: _OutsideFinder(found(rng)), is_random=True)


def outside_source(name: str) -> str:
    """The text of all modules of an outside tracker: with another text its results are others.

    These are its own module and those that it imports, directly or not, from the same top-level
    package or, where that is not installed, from the same folder; in the order of their names.
    Data files and compiled modules do not count.
    """
    _load(name)
    return _source(sys.modules[name.partition(":")[0]])


def _load(name: str) -> Any:
    """The class at an import path, fresh if its source was edited since it was loaded."""
    module_name, _, class_name = name.partition(":")
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.insert(0, here)
    try:
        module = importlib.import_module(module_name)
        source = _source(module)
        if vars(module).setdefault(_LOADED_SOURCE, source) != source:
            for other in _own_modules(module):
                sys.modules.pop(other, None)
            importlib.invalidate_caches()
            module = importlib.import_module(module_name)
            setattr(module, _LOADED_SOURCE, source)
    except ImportError as error:
        raise ValueError(f"tracker {name!r}: {error}") from error
    found = getattr(module, class_name, None)
    if not inspect.isclass(found):
        raise ValueError(f"tracker {name!r}: {module_name} has no class {class_name!r}")
    for method in ("start", "find"):
        if not callable(getattr(found, method, None)):
            raise ValueError(f"tracker {name!r}: {class_name} has no method {method!r}")
    return found


def _source(module: ModuleType) -> str:
    files = _own_modules(module)
    return "".join(Path(files[name]).read_text(encoding="utf-8") for name in sorted(files))


def _own_modules(module: ModuleType) -> dict[str, str]:
    """Name and file of the module, and of what it imports from its own package or folder."""
    top = sys.modules[module.__name__.partition(".")[0]]
    folder = Path(top.__path__[0] if hasattr(top, "__path__") else str(top.__file__)).parent
    finder = _OwnModuleFinder([str(folder)], excludes=_THIS_PROJECT)
    finder.only = top.__name__ if folder.name in ("site-packages", "dist-packages") else None
    with contextlib.suppress(ImportError, SyntaxError):  # of what is not imported, or not so
        finder.import_hook(module.__name__)
    modules: dict[str, Any] = finder.modules | {module.__name__: module}
    files: dict[str, str | None] = {name: found.__file__ for name, found in modules.items()}
    return {name: file for name, file in files.items() if file and file.endswith(".py")}


class _OwnModuleFinder(ModuleFinder):
    """Reads import statements, and finds modules in its path alone, none of the standard library.

    Among installed packages it finds that of the name `only`.
    """

    only: str | None = None

    def find_module(self, name: str, path: Any, parent: Any = None) -> Any:
        if parent is None and self.only not in (None, name):
            raise ImportError(name)
        return super().find_module(name, path, parent)


class _OutsideFinder:
    """Takes what a tracker from outside returns for what it is."""

    def __init__(self, finder: Any) -> None:
        self._finder = finder

    def start(self, image: np.ndarray, box: np.ndarray) -> None:
        """See `BoxFinder`."""
        self._finder.start(image, box)

    def find(self, image: np.ndarray) -> BoxEstimate | None:
        """See `BoxFinder`; ValueError for what is no box."""
        found = self._finder.find(image)
        if found is None or isinstance(found, BoxEstimate):
            return found
        box = np.asarray(found, float)
        if box.shape != (4,):
            raise ValueError(f"find() must return four numbers or None, got {found!r}")
        return BoxEstimate(box)
