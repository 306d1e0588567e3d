"""OpenCV's trackers as box finders, made reproducible."""

import ctypes
import sys
from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np

from tracker.box_tracker import BoxEstimate

_C_LIBRARY = ctypes.CDLL("ucrtbase" if sys.platform == "win32" else None)


class OpenCVFinder:
    """One of OpenCV's trackers.

    MIL draws from OpenCV's global generator and from the C library's, TLD from the latter. Both
    are seeded from `rng` before every call, so that the boxes depend on it alone and not on what
    else ran in the process. OpenCV must run on one thread (`cv2.setNumThreads(1)`).
    """

    def __init__(
        self, class_name: str, settings: Mapping[str, float], rng: np.random.Generator
    ) -> None:
        """`settings` replace fields of the class's parameters."""
        self._class_name = class_name
        self._settings = settings
        self._rng = rng
        self._tracker: Any = None

    def start(self, image: np.ndarray, box: np.ndarray) -> None:
        """See `BoxFinder`."""
        self._reseed()
        create: Any = find_in_opencv(f"{self._class_name}_create")
        if self._settings:
            parameters: Any = find_in_opencv(f"{self._class_name}_Params")()
            for name, value in self._settings.items():
                setattr(parameters, name, value)
            self._tracker = create(parameters)
        else:
            self._tracker = create()
        self._tracker.init(image, tuple(int(v) for v in box))

    def find(self, image: np.ndarray) -> BoxEstimate | None:
        """See `BoxFinder`."""
        self._reseed()
        is_found, box = self._tracker.update(image)
        return BoxEstimate(np.array(box, float)) if is_found else None

    def _reseed(self) -> None:
        opencv_seed, c_seed = (int(seed) for seed in self._rng.integers(2**31, size=2))
        cv2.setRNGSeed(opencv_seed)
        _C_LIBRARY.srand(c_seed)


def find_in_opencv(path: str) -> Any:
    """The attribute of cv2 at a dotted path, None where the installed OpenCV lacks it."""
    found: Any = cv2
    for name in path.split("."):
        found = getattr(found, name, None)
    return found
