"""Lucas-Kanade: aligns a fixed template with the image, by a shift and then by an affine warp.

OpenCV's `findTransformECC` does it: Gauss-Newton steps on the correlation of template and image
[ECC2008], in the forward-additive form.
"""

import contextlib
import math
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from tracker.affine import aff2
from tracker.base import Status, WarpEstimate
from tracker.box_tracker import BoxEstimate, box_of_warp, warp_of_box
from tracker.peers.box_finder import cut


@dataclass(frozen=True)
class EccConfig:
    """Resolutions, and what counts as found."""

    shift_side_px: int = 12
    """Mean side of the template that is shifted."""
    affine_side_px: int = 32
    """Mean side of the template that is warped."""
    window: float = 2.5
    """Side of the image window relative to the template's longer side."""
    iterations: int = 20
    """Steps of each alignment, at most."""
    min_ncc: float = 0.3
    """Correlation from which an alignment counts."""
    max_log_stretch: float = 1.4
    """Logarithm of the largest change of size or shape since the start."""


@dataclass(frozen=True, eq=False)
class _Level:
    """The template at one resolution, and what to fit there."""

    motion: int
    """MOTION_TRANSLATION or MOTION_AFFINE of OpenCV."""
    picture: np.ndarray
    """(rows, columns) uint8."""
    to_template: np.ndarray
    """(3, 3) picture pixels -> template coordinates."""


class EccFinder:
    """Follows on Aff(2) without a filter: the last warp is where the search begins."""

    def __init__(self, config: EccConfig | None = None) -> None:
        self._config = config or EccConfig()
        self._levels: list[_Level] = []
        self._warp = np.eye(3)
        self._unit_px = 1.0
        self._size = (1.0, 1.0)

    def start(self, image: np.ndarray, box: np.ndarray) -> None:
        """See `BoxFinder`."""
        picture = cut(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), box)
        self._warp = warp_of_box(box)
        self._unit_px = float(self._warp[0, 0])
        self._size = box[2] / self._unit_px, box[3] / self._unit_px
        self._levels = [
            _level(picture, self._config.shift_side_px, cv2.MOTION_TRANSLATION),
            _level(picture, self._config.affine_side_px, cv2.MOTION_AFFINE),
        ]

    def find(self, image: np.ndarray) -> BoxEstimate | None:
        """See `BoxFinder`; `cv2.error` where the affine steps do not converge."""
        grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        shift, affine = self._levels
        warp = self._warp
        with contextlib.suppress(cv2.error):
            shifted, _ = self._align(grey, shift, warp)
            warp = shifted if self._is_plausible(shifted, grey.shape) else warp
        warp, ncc = self._align(grey, affine, warp)
        if ncc < self._config.min_ncc or not self._is_plausible(warp, grey.shape):
            return None
        self._warp = warp
        return BoxEstimate(box_of_warp(warp, self._size), _estimate(warp, ncc))

    def _align(self, grey: np.ndarray, level: _Level, warp: np.ndarray) -> tuple[np.ndarray, float]:
        """The warp aligned on one level, and its correlation; `cv2.error` without convergence."""
        config = self._config
        to_image = warp @ level.to_template
        side = math.ceil(config.window * max(level.picture.shape))
        side_px = max(4, round(side * math.sqrt(np.linalg.det(to_image[:2, :2]))))
        corner = np.rint(warp[:2, 2] - (side_px - 1) / 2).astype(int)
        window = cut(grey, np.array([*corner, side_px, side_px]))
        window = cv2.resize(window, (side, side), interpolation=cv2.INTER_AREA)
        step = side_px / side
        origin = corner + (step - 1.0) / 2.0
        from_window = np.array([[step, 0.0, origin[0]], [0.0, step, origin[1]], [0.0, 0.0, 1.0]])
        guess = (aff2.inverse(from_window) @ to_image)[:2].astype(np.float32)
        criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, config.iterations, 1e-4)
        align: Any = cv2.findTransformECC  # its annotation forbids the empty mask
        ncc, aligned = align(level.picture, window, guess, level.motion, criteria, None, 3)
        in_window = np.vstack([aligned.astype(float), [0.0, 0.0, 1.0]])
        return from_window @ in_window @ aff2.inverse(level.to_template), float(ncc)

    def _is_plausible(self, warp: np.ndarray, shape_px: tuple[int, ...]) -> bool:
        if not aff2.is_valid(warp):
            return False
        parameters = aff2.polar(warp)
        scale = parameters[0] - math.log(self._unit_px)
        stretch = abs(scale) + math.hypot(parameters[1], parameters[3])
        is_inside = (warp[:2, 2] >= 0).all() and (warp[:2, 2] < shape_px[1::-1]).all()
        return bool(is_inside and stretch <= self._config.max_log_stretch)


def _level(picture: np.ndarray, side_px: int, motion: int) -> _Level:
    """The picture reduced to a mean side of `side_px`; a small one keeps its size."""
    height, width = picture.shape
    unit = math.sqrt(width * height)
    reduction = max(1.0, unit / side_px)
    columns, rows = (max(6, round(n / reduction)) for n in (width, height))
    small = cv2.resize(picture, (columns, rows), interpolation=cv2.INTER_AREA)
    u, v = width / unit / columns, height / unit / rows
    to_template = np.array(
        [[u, 0.0, -u * (columns - 1) / 2], [0.0, v, -v * (rows - 1) / 2], [0.0, 0.0, 1.0]]
    )
    return _Level(motion, small, to_template)


def _estimate(warp: np.ndarray, ncc: float) -> WarpEstimate:
    """One warp, of which nothing but the correlation says how good it is."""
    unknown = np.full((6, 6), np.nan)
    return WarpEstimate(warp, unknown, ncc=ncc, visible_fraction=1.0, status=Status.TRACKING)
