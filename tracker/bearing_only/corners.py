"""Corners with names: detected, followed from image to image, and dropped where doubtful.

Pixels count as those of `PinholeCamera`: from the image's upper left edge, so that the middle of
the first pixel is (0.5, 0.5). OpenCV counts from that middle.
"""

from dataclasses import dataclass
from typing import Any, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from tracker.bearing_only.measurements import FeatureObservation
from tracker.checks import require_count, require_positive, require_share

Rectangle: TypeAlias = tuple[int, int, int, int]
"""Left, top, width and height [px] of a part of an image."""

HALF_PX = 0.5
"""Distance from the middle of the first pixel, OpenCV's origin, to the edge of the image."""

SLOT_PX = 32
"""Side of a slot; a patch fills it but for one pixel."""
_REACH_PX = SLOT_PX // 2 - 1
_CRITERIA = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 30, 0.003)


@dataclass(frozen=True)
class CornerConfig:
    """How corners are found and followed."""

    count: int = 40
    """So many are followed; new ones are looked for when `refill` of them or fewer are left."""
    refill: float = 0.8
    spacing_px: float = 30.0
    """Least distance between a new corner and the others."""
    quality: float = 0.05
    """Least corner response, as a share of the image's greatest."""
    window_px: int = 15
    """Side of the patch that is followed."""
    levels: int = 3
    """Pyramid levels above the image."""
    return_px: float = 0.3
    """Farthest that a corner may come back from where it started, followed forth and back."""
    step_levels: float = 15.0
    """Greatest mean difference of the patches in two successive images, in grey levels."""
    drift_px: float = 1.0
    """Farthest that a corner may have moved from where its first patch fits best."""
    likeness_levels: float = 30.0
    """Greatest mean difference from the first patch, in grey levels."""
    renewal_levels: float = 8.0
    """Mean difference from the first patch beyond which the present one takes its place."""
    margin_px: int = 10
    """Corners nearer to the image's border are dropped."""

    def __post_init__(self) -> None:
        require_count(self, "count", "levels", "margin_px")
        require_share(self, "refill", "quality")
        require_positive(self, "spacing_px", "return_px", "step_levels", "drift_px")
        require_positive(self, "likeness_levels", "renewal_levels")
        if not (3 <= self.window_px < SLOT_PX and self.window_px % 2):
            raise ValueError(
                f"window_px must be an odd number from 3 to {SLOT_PX - 1}, got {self.window_px}"
            )


class CornerTracker:
    """Follows corners [ShiTomasi1994] by pyramidal Lucas-Kanade [Bouguet2001].

    A corner is kept while it comes back to where it started when it is followed to the new image
    and back, as in [MedianFlow2010]. It is then moved to where its first patch fits best, so that
    it does not creep along from image to image; as the view changes, the patch is renewed. Wrong
    corners that pass (where a near edge crosses a far one) are found by
    `tracker.bearing_only.rigidity`. A corner that is lost never comes back.
    """

    def __init__(self, config: CornerConfig | None = None) -> None:
        self.config = config or CornerConfig()
        self._grey: NDArray[np.uint8] | None = None
        self._patches = PatchStore((SLOT_PX, SLOT_PX))
        self._points = np.empty((0, 2), np.float32)
        self._ids = np.empty(0, np.int64)
        self._slots = np.empty(0, np.int64)
        self._next_id = 0

    def update(self, grey: NDArray[np.uint8], avoid: Rectangle | None = None) -> FeatureObservation:
        """The corners in the next image.

        Args:
            grey: (h, w) uint8.
            avoid: A part without landmarks, such as the moving target.
        """
        self._check(grey)
        if self._grey is not None and len(self._points):
            self._follow(self._grey, grey)
            self._anchor(grey)
        self._keep(self._is_clear(self._points, grey.shape, avoid))
        self._keep(self._is_apart())
        if len(self._points) <= self.config.refill * self.config.count:
            self._detect(grey, avoid)
        self._grey = grey
        return FeatureObservation(self._ids, self._points.astype(np.float64) + HALF_PX)

    def drop(self, ids: NDArray[np.int64]) -> None:
        """Follows the corners of these names no longer."""
        self._keep(~np.isin(self._ids, ids))

    def _check(self, grey: NDArray[np.uint8]) -> None:
        """ValueError for an image that does not fit; the first one decides the size."""
        if grey.ndim != 2 or grey.dtype != np.uint8:
            raise ValueError(f"grey must be (h, w) uint8, got {grey.shape} {grey.dtype}")
        if self._grey is None:
            self._patches = PatchStore((grey.shape[0], grey.shape[1]))
            if len(self._patches) < self.config.count:
                raise ValueError(
                    f"count must be {len(self._patches)} or fewer for images of {grey.shape[1]} x "
                    f"{grey.shape[0]} px, got {self.config.count}"
                )
        elif grey.shape != self._grey.shape:
            raise ValueError(f"images must be alike, got {grey.shape} after {self._grey.shape}")

    def _follow(self, before: NDArray[np.uint8], now: NDArray[np.uint8]) -> None:
        levels = self.config.levels
        moved, found, difference = self._flow((before, now), self._points, self._points, levels)
        back, found_back, _ = self._flow((now, before), moved, self._points, levels)
        away = np.linalg.norm(back - self._points, axis=1)
        self._points = moved
        is_back = found & found_back & (away <= self.config.return_px)
        self._keep(is_back & (difference <= self.config.step_levels))

    def _anchor(self, now: NDArray[np.uint8]) -> None:
        """Moves the corners to where their first patches fit; drops those that do not fit."""
        if not len(self._points):
            return
        start = self._patches.centres_px[self._slots]
        fitted, found, difference = self._flow((self._patches.picture, now), start, self._points, 0)
        away = np.linalg.norm(fitted - self._points, axis=1)
        is_good = found & (away <= self.config.drift_px)
        is_good &= difference <= self.config.likeness_levels
        self._points = fitted
        for index in np.flatnonzero(is_good & (difference > self.config.renewal_levels)):
            self._patches.keep(int(self._slots[index]), now, fitted[index])
        self._keep(is_good)

    def _flow(
        self,
        pair: tuple[NDArray[np.uint8], NDArray[np.uint8]],
        start: NDArray[np.float32],
        guess: NDArray[np.float32],
        levels: int,
    ) -> tuple[NDArray[np.float32], NDArray[np.bool_], NDArray[np.float32]]:
        """Where points of the first image are in the second, which were found, how they differ."""
        side = self.config.window_px
        moved, found, difference = cv2.calcOpticalFlowPyrLK(
            *pair,
            start,
            guess.copy(),
            winSize=(side, side),
            maxLevel=levels,
            criteria=_CRITERIA,
            flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
        )
        return np.asarray(moved, np.float32), found.ravel() == 1, np.float32(difference).ravel()

    def _keep(self, is_good: NDArray[np.bool_]) -> None:
        self._points, self._ids = self._points[is_good], self._ids[is_good]
        self._slots = self._slots[is_good]

    def _is_clear(
        self, points: NDArray[np.float32], shape: tuple[int, ...], avoid: Rectangle | None
    ) -> NDArray[np.bool_]:
        """Which points are neither at the border nor in the part to avoid."""
        margin = self.config.margin_px
        x, y = points.T
        is_clear = (x >= margin) & (x < shape[1] - margin) & (y >= margin) & (y < shape[0] - margin)
        if avoid is not None:
            left, top, width, height = avoid
            is_in = (x >= left) & (x < left + width) & (y >= top) & (y < top + height)
            is_clear &= ~is_in
        return is_clear

    def _is_apart(self) -> NDArray[np.bool_]:
        """Which corners have no older one within half the spacing."""
        gaps = np.linalg.norm(self._points[:, None] - self._points, axis=2)
        is_near = np.tril(gaps < 0.5 * self.config.spacing_px, k=-1)
        return ~is_near.any(axis=1)

    def _detect(self, grey: NDArray[np.uint8], avoid: Rectangle | None) -> None:
        """Adds new corners, the strongest first, far enough from those that are followed."""
        mask = np.full(grey.shape, 255, np.uint8)
        for x, y in np.rint(self._points).astype(int).tolist():
            cv2.circle(mask, (x, y), round(self.config.spacing_px), 0, -1)
        found: Any = cv2.goodFeaturesToTrack(
            grey, self.config.count, self.config.quality, self.config.spacing_px, mask=mask
        )
        # OpenCV gives None, against its own annotation, where there is no corner.
        fresh = np.asarray([] if found is None else found, np.float32).reshape(-1, 2)
        fresh = fresh[self._is_clear(fresh, grey.shape, avoid)]
        fresh = fresh[: self.config.count - len(self._points)]
        slots = np.setdiff1d(np.arange(len(self._patches)), self._slots)[: len(fresh)]
        for slot, point in zip(slots, fresh, strict=True):
            self._patches.keep(int(slot), grey, point)
        self._points = np.concatenate([self._points, fresh])
        self._ids = np.concatenate([self._ids, self._next_id + np.arange(len(fresh))])
        self._slots = np.concatenate([self._slots, slots])
        self._next_id += len(fresh)


class PatchStore:
    """The landmarks' patches as they were first seen: as many as fit into a picture of that size.

    All are in one picture, because OpenCV's Lucas-Kanade compares many points of two in one call.

    Args:
        shape: Rows and columns of the camera's images.
    """

    def __init__(self, shape: tuple[int, int]) -> None:
        rows, columns = (np.arange(SLOT_PX // 2, n - SLOT_PX // 2 + 1, SLOT_PX) for n in shape)
        x, y = np.meshgrid(columns, rows)
        self.centres_px: NDArray[np.float32] = np.column_stack([x.ravel(), y.ravel()]).astype(
            np.float32
        )
        """(n, 2) the middle of each slot, which is the landmark."""
        self.picture: NDArray[np.uint8] = np.zeros(shape, np.uint8)

    def __len__(self) -> int:
        return len(self.centres_px)

    def keep(self, slot: int, grey: NDArray[np.uint8], point_px: NDArray[np.float32]) -> None:
        """Puts what is around a point of an image into a slot, sampled between the pixels."""
        side = 2 * _REACH_PX + 1
        x, y = (round(float(value)) for value in self.centres_px[slot])
        patch = cv2.getRectSubPix(grey, (side, side), (float(point_px[0]), float(point_px[1])))
        rows = slice(y - _REACH_PX, y + _REACH_PX + 1)
        self.picture[rows, x - _REACH_PX : x + _REACH_PX + 1] = patch
