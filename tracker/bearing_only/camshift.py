"""The target by its colour: CamShift on the back-projection of its hues.

Source: [Bradski1998]; [Wu2022] section 6.1.2 finds its target so, and gives no settings.
Pixels count as those of `PinholeCamera`; see `tracker.bearing_only.corners`.
"""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from tracker.bearing_only.corners import HALF_PX, Rectangle
from tracker.checks import require_count, require_positive, require_share

SightingStatus: TypeAlias = Literal["tracked", "found", "cut", "lost"]
"""Followed from the last image; found in the whole image; cut off by the border; not seen."""

_HUES = 180
"""OpenCV's hues of an 8-bit image, of 2 degrees each."""


@dataclass(frozen=True)
class CamShiftConfig:
    """How the target is separated from the rest."""

    bins: int = 36
    """Number of bins of the histogram of hues."""
    least_saturation: int = 110
    """Saturation, of 255, below which the hue of a pixel says nothing."""
    least_value: int = 40
    """Value, of 255, below which the hue of a pixel says nothing."""
    least_area_px: float = 12.0
    """A smaller target is taken for noise."""
    least_density: float = 0.3
    """Least share of the window that must have the target's colour; a disc has 0.79."""
    reach: float = 2.0
    """The target is looked for within so many times its window's size, and `reach_px`, around."""
    reach_px: int = 24

    def __post_init__(self) -> None:
        require_count(self, "bins", "least_saturation", "least_value", "reach_px")
        require_positive(self, "least_area_px", "reach")
        require_share(self, "least_density")
        if self.bins > _HUES:
            raise ValueError(f"bins must be {_HUES} or fewer, got {self.bins}")


@dataclass(frozen=True, eq=False)
class Sighting:
    """The target in one image."""

    status: SightingStatus
    centre_px: NDArray[np.float64] | None
    """(2,) centroid of its colour; None where it is lost."""
    window: Rectangle | None
    """Its window, in OpenCV's pixels; None where it is lost."""

    @property
    def is_whole(self) -> bool:
        """Whether the centroid is that of the whole target."""
        return self.status in ("tracked", "found")


class ColourModel:
    """How often each hue is seen on the target.

    Args:
        patch: (h, w, 3) uint8 RGB of the target alone, such as the middle of a photograph.
        config: The settings; the same as those of the `CamShift` that uses the model.
    """

    def __init__(self, patch: NDArray[np.uint8], config: CamShiftConfig | None = None) -> None:
        self.config = config or CamShiftConfig()
        hsv, mask = self._hsv(patch)
        if not mask.any():
            raise ValueError("the patch has no coloured pixel, so its hues say nothing")
        histogram = cv2.calcHist([hsv], [0], mask, [self.config.bins], [0, _HUES])
        self._histogram = 255.0 * histogram / histogram.max()

    def likelihood(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """(h, w) uint8: how much each pixel of (h, w, 3) uint8 RGB looks like the target."""
        hsv, mask = self._hsv(image)
        back = cv2.calcBackProject([hsv], [0], self._histogram, [0, _HUES], 1.0)
        return np.asarray(cv2.bitwise_and(back, mask), np.uint8)

    def _hsv(self, image: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        """Hue, saturation and value, and 255 where the hue says something."""
        hsv = cv2.cvtColor(np.ascontiguousarray(image), cv2.COLOR_RGB2HSV)
        least = (0, self.config.least_saturation, self.config.least_value)
        mask = cv2.inRange(hsv, np.array(least, np.uint8), np.array((255, 255, 255), np.uint8))
        return np.asarray(hsv, np.uint8), np.asarray(mask, np.uint8)


class CamShift:
    """Follows the target's window; looks for it in the whole image where it has none."""

    def __init__(self, model: ColourModel) -> None:
        self.model, self.config = model, model.config
        self._window: Rectangle | None = None

    def update(self, image: NDArray[np.uint8]) -> Sighting:
        """The target in (h, w, 3) uint8 RGB, the next image."""
        if image.ndim != 3 or image.shape[2] != 3 or image.dtype != np.uint8:
            raise ValueError(f"image must be (h, w, 3) uint8, got {image.shape} {image.dtype}")
        if self._window is not None:
            sighting = self._follow(image, self._window, "tracked")
            if sighting is not None:
                return sighting
        return self._search(image)

    def _search(self, image: NDArray[np.uint8]) -> Sighting:
        """The largest blob of the target's colour in the whole image."""
        likelihood = self.model.likelihood(image)
        is_like = (likelihood > 127).astype(np.uint8)
        _, _, blobs, _ = cv2.connectedComponentsWithStats(is_like, connectivity=8)
        areas = blobs[1:, cv2.CC_STAT_AREA]
        if areas.size and areas.max() >= self.config.least_area_px:
            left, top, width, height, _ = blobs[1 + int(np.argmax(areas))].tolist()
            sighting = self._follow(image, (left, top, width, height), "found")
            if sighting is not None:
                return sighting
        self._window = None
        return Sighting("lost", None, None)

    def _follow(
        self, image: NDArray[np.uint8], window: Rectangle, status: SightingStatus
    ) -> Sighting | None:
        """CamShift from `window`; None where it ends on too little of the target's colour."""
        part = _grown(window, self.config.reach, self.config.reach_px, image.shape)
        left, top, width, height = part
        likelihood = self.model.likelihood(image[top : top + height, left : left + width])
        start = window[0] - left, window[1] - top, window[2], window[3]
        if not likelihood.any():
            return None
        _, shifted = cv2.CamShift(likelihood, start, _CRITERIA)
        x, y, columns, rows = shifted
        if columns <= 0 or rows <= 0:
            return None
        around = _grown((x, y, columns, rows), 0.25, 2, likelihood.shape)
        seen = likelihood[around[1] : around[1] + around[3], around[0] : around[0] + around[2]]
        moments = cv2.moments(seen)
        mass = moments["m00"] / 255.0
        if mass < max(self.config.least_area_px, self.config.least_density * columns * rows):
            return None
        # OpenCV rounds the centre of its window to whole pixels; the moments are exact.
        offset = np.array([left + around[0], top + around[1]]) + HALF_PX
        centre = offset + np.array([moments["m10"], moments["m01"]]) / moments["m00"]
        self._window = x + left, y + top, columns, rows
        return Sighting(
            "cut" if _touches_border(self._window, image.shape) else status, centre, self._window
        )


def _grown(window: Rectangle, share: float, px: int, shape: tuple[int, ...]) -> Rectangle:
    """The window with a rim of `share` of its size and `px` pixels, as far as the image goes."""
    left, top, width, height = window
    rim_x, rim_y = round(share * width) + px, round(share * height) + px
    right, bottom = min(left + width + rim_x, shape[1]), min(top + height + rim_y, shape[0])
    left, top = max(left - rim_x, 0), max(top - rim_y, 0)
    return left, top, right - left, bottom - top


def _touches_border(window: Rectangle, shape: tuple[int, ...]) -> bool:
    left, top, width, height = window
    return left <= 1 or top <= 1 or left + width >= shape[1] - 1 or top + height >= shape[0] - 1


_CRITERIA = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 20, 1.0)
