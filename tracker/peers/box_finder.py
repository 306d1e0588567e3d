"""What every baseline shares: it finds a box or fails, and the last box is held where it fails."""

from dataclasses import replace
from typing import Protocol

import cv2
import numpy as np

from tracker.base import Status
from tracker.box_tracker import BoxEstimate

_FLAT_DEVIATION = 1.0


class BoxFinder(Protocol):
    """Finds a target again in the next image of a video."""

    def start(self, image: np.ndarray, box: np.ndarray) -> None:
        """Takes the target in `box` (4,) of the BGR `image` (h, w, 3).

        The box is of whole pixels and lies in the image.
        """
        ...

    def find(self, image: np.ndarray) -> BoxEstimate | None:
        """The target in the next BGR image; None, or `cv2.error`, where it is not found."""
        ...


class HoldingTracker:
    """A `BoxTracker` that asks a finder and holds its last box where it finds nothing."""

    def __init__(self, finder: BoxFinder) -> None:
        self._finder = finder
        self._last: BoxEstimate | None = None
        self.is_found = False
        """Whether the newest box was found in the newest image, not held."""

    def start(self, image: np.ndarray, box: np.ndarray) -> None:
        """See `BoxTracker`; the box is rounded, and cut off at the borders of the image."""
        box = _checked(image, box)
        try:
            self._finder.start(image, box)
        except cv2.error as error:
            raise ValueError(f"box must suit the tracker, got {_text(box)}: {error.err}") from error
        self._last, self.is_found = BoxEstimate(box), True

    @property
    def box(self) -> np.ndarray:
        """(4,) the newest box; after `start` the one that was taken."""
        if self._last is None:
            raise ValueError("box before start()")
        return self._last.box

    def update(self, image: np.ndarray) -> BoxEstimate:
        """See `BoxTracker`."""
        if self._last is None:
            raise ValueError("update() before start()")
        try:
            found = self._finder.find(image)
        except cv2.error:
            found = None
        self.is_found = found is not None and _has_area(found.box)
        self._last = found if found is not None and self.is_found else _held(self._last)
        return self._last


def cut(grey: np.ndarray, box: np.ndarray) -> np.ndarray:
    """(h, w) copy of the whole-pixel `box` (4,) of `grey`; beyond the image its edge repeats."""
    x, y, w, h = (int(v) for v in box)
    columns = np.arange(x, x + w).clip(0, grey.shape[1] - 1)
    rows = np.arange(y, y + h).clip(0, grey.shape[0] - 1)
    return grey[np.ix_(rows, columns)]


def _checked(image: np.ndarray, box: np.ndarray) -> np.ndarray:
    """(4,) whole pixels of the box that lie in the image; ValueError if it cannot be tracked."""
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3:
        raise ValueError(f"image must be uint8 (h, w, 3), got {image.dtype} {image.shape}")
    box = np.array(box, float)
    if box.shape != (4,) or not _has_area(box) or box[2:].min() < 1.0:
        raise ValueError(f"box must be x, y, w, h with w and h of 1 px or more, got {_text(box)}")
    limit = np.array(image.shape[1::-1])
    whole = np.rint(np.clip(box, -1e6, 1e6)).astype(int)
    low, high = whole[:2].clip(0, limit), (whole[:2] + whole[2:]).clip(0, limit)
    if (high <= low).any():
        raise ValueError(
            f"box must lie in the image of {limit[0]} x {limit[1]} px, got {_text(box)}"
        )
    if float(image[low[1] : high[1], low[0] : high[0]].std()) < _FLAT_DEVIATION:
        raise ValueError(f"box must hold texture, its grey values are all but equal: {_text(box)}")
    return np.concatenate([low, high - low]).astype(float)


def _has_area(box: np.ndarray) -> bool:
    return bool(np.isfinite(box).all() and (box[2:] > 0).all())


def _held(last: BoxEstimate) -> BoxEstimate:
    affine = last.affine and replace(last.affine, ncc=0.0, status=Status.UNCERTAIN)
    return BoxEstimate(last.box, affine)


def _text(box: np.ndarray) -> str:
    return ", ".join(f"{v:g}" for v in np.ravel(box))
