"""Trackers from outside this repository, named by import path: `my_package.my_module:MyTracker`.

Such a class is made with a `numpy.random.Generator` and has two methods:

    start(image, box)    image (h, w, 3) uint8 BGR; box (4,) x, y, w, h [px], whole pixels
    find(image)          the box in the next image, four numbers, or None where it is not found

`find` may also return a `tracker.box_tracker.BoxEstimate`, if it knows a warp. In the conveyor
loop the images are the overhead ones, and detection and reconstruction are those of every tracker.
"""

from __future__ import annotations

import importlib
import inspect
import sys
from pathlib import Path
from typing import Any

import numpy as np

from tracker.box_tracker import BoxEstimate
from tracker.checks import require_known
from tracker.peers.baselines import BASELINES, Baseline


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


def source_of(name: str) -> str:
    """Text of the module of an outside tracker: with other text its results are others."""
    return inspect.getsource(sys.modules[_load(name).__module__])


def _load(name: str) -> Any:
    module_name, _, class_name = name.partition(":")
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.insert(0, here)
    try:
        module = importlib.import_module(module_name)
    except ImportError as error:
        raise ValueError(f"tracker {name!r}: {error}") from error
    found = getattr(module, class_name, None)
    if not inspect.isclass(found):
        raise ValueError(f"tracker {name!r}: {module_name} has no class {class_name!r}")
    for method in ("start", "find"):
        if not callable(getattr(found, method, None)):
            raise ValueError(f"tracker {name!r}: {class_name} has no method {method!r}")
    return found


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
