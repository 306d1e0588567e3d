"""The trackers that people would pick instead, by name, behind the interface of box trackers.

`template` and `ecc` are built from functions of any OpenCV, `mil` is in any OpenCV; the others are
in OpenCV's contrib modules, which are not in the wheel that is installed by default.
"""

import ctypes
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import cv2
import numpy as np

from tracker.box_tracker import BoxEstimate
from tracker.peers.box_finder import BoxFinder, HoldingTracker
from tracker.peers.ecc import EccFinder
from tracker.peers.template_matching import TemplateMatcher

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


@dataclass(frozen=True)
class Baseline:
    """A tracker to compare with, and how to make a fresh one."""

    description: str
    """One line for listings."""
    build: Callable[[np.random.Generator], BoxFinder]
    """Makes the part that finds; `make` is what to call."""
    opencv_class: str = ""
    """Class of OpenCV without which it cannot run; empty if it needs none."""
    is_random: bool = False
    """Whether the answer depends on the seed; others need one run."""

    @property
    def is_available(self) -> bool:
        """Whether the installed OpenCV has what the tracker needs."""
        return not self.opencv_class or bool(find_in_opencv(f"{self.opencv_class}_create"))

    def require_available(self) -> None:
        """Raises ValueError that says how to install what is missing."""
        if not self.is_available:
            raise ValueError(
                f"the installed OpenCV {cv2.__version__} has no {self.opencv_class}; `make peers` "
                "makes an environment of which the OpenCV has: .venv-peers/bin/beltgrasp"
            )

    def make(self, rng: np.random.Generator) -> HoldingTracker:
        """A fresh tracker; ValueError where the installed OpenCV lacks it."""
        self.require_available()
        return HoldingTracker(self.build(rng))


def _opencv(
    class_name: str, description: str, is_random: bool = False, **settings: float
) -> Baseline:
    build = partial(OpenCVFinder, class_name, settings)
    return Baseline(description, build, class_name, is_random)


BASELINES: dict[str, Baseline] = {
    "csrt": _opencv("TrackerCSRT", "OpenCV: correlation filter with channel and spatial weights"),
    "kcf": _opencv("TrackerKCF", "OpenCV: kernelised correlation filter, default threshold of 0.5"),
    "kcf-0.1": _opencv(
        "TrackerKCF", "OpenCV: kernelised correlation filter, threshold of 0.1", detect_thresh=0.1
    ),
    "mil": _opencv("TrackerMIL", "OpenCV: boosting on bags of patches", is_random=True),
    "boosting": _opencv("legacy.TrackerBoosting", "OpenCV: online AdaBoost on patches"),
    "tld": _opencv(
        "legacy.TrackerTLD", "OpenCV: median flow and a learned detector", is_random=True
    ),
    "medianflow": _opencv("legacy.TrackerMedianFlow", "OpenCV: median of forward-backward flow"),
    "mosse": _opencv("legacy.TrackerMOSSE", "OpenCV: plain correlation filter"),
    "ecc": Baseline(
        "Lucas-Kanade: affine alignment of the first picture by OpenCV's findTransformECC",
        lambda rng: EccFinder(),
    ),
    "template": Baseline(
        "matching of the first picture by normalised correlation, at three sizes",
        lambda rng: TemplateMatcher(),
    ),
}
"""[CSRT2017], [KCF2015], [MIL2009], [Boosting2006], [TLD2012], [MedianFlow2010], [MOSSE2010],
[ECC2008]. OpenCV's KCF is not the published one: it has no histograms of gradients, and with its
default threshold it gives up on most images of the usual sequences."""
