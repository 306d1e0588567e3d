"""Template matching: the first picture of the target, slid over a window around the last place."""

from dataclasses import dataclass

import cv2
import numpy as np

from tracker.box_tracker import BoxEstimate
from tracker.peers.box_finder import cut


@dataclass(frozen=True)
class MatchingConfig:
    """Where to look, and what counts as found."""

    reach: float = 0.6
    """The window extends this share of the target's mean side beyond the last box."""
    scale_step: float = 1.03
    """Ratio of the three sizes that are tried about the last one."""
    scale_range: tuple[float, float] = (0.25, 4.0)
    """Sizes relative to the first box."""
    min_ncc: float = 0.4
    """Normalised correlation from which a match counts."""
    max_side_px: int = 64
    """Larger targets are searched for at a lower resolution, where this is their longer side."""


class TemplateMatcher:
    """Normalised cross-correlation with the first picture, which is never updated."""

    def __init__(self, config: MatchingConfig | None = None) -> None:
        self._config = config or MatchingConfig()
        self._picture = np.empty((0, 0), np.uint8)
        self._centre = np.zeros(2)
        self._size = np.zeros(2)
        self._reduction = 1.0
        self._scale = 1.0

    def start(self, image: np.ndarray, box: np.ndarray) -> None:
        """See `BoxFinder`."""
        self._picture = cut(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), box)
        self._size = np.array(box[2:])
        self._centre = box[:2] + (self._size - 1.0) / 2.0
        self._reduction = max(1.0, float(self._size.max()) / self._config.max_side_px)
        self._scale = 1.0

    def find(self, image: np.ndarray) -> BoxEstimate | None:
        """See `BoxFinder`."""
        grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        config = self._config
        steps = (1.0, 1.0 / config.scale_step, config.scale_step)
        scales = [float(np.clip(self._scale * step, *config.scale_range)) for step in steps]
        matches = [self._match(grey, scale) for scale in scales]
        best = int(np.argmax([ncc for ncc, _ in matches]))
        ncc, centre = matches[best]
        if ncc < config.min_ncc:
            return None
        self._centre, self._scale = centre, scales[best]
        size = self._size * self._scale
        return BoxEstimate(np.concatenate([centre - (size - 1.0) / 2.0, size]))

    def _match(self, grey: np.ndarray, scale: float) -> tuple[float, np.ndarray]:
        """Best correlation at one size, and the centre of the target there."""
        size = self._size * scale
        reach = self._config.reach * float(np.sqrt(size.prod()))
        corner = np.rint(self._centre - (size - 1.0) / 2.0 - reach).astype(int)
        extent = np.rint(size + 2.0 * reach).astype(int)
        window = cut(grey, np.concatenate([corner, extent]))
        window = _resized(window, extent / self._reduction)
        picture = _resized(self._picture, size / self._reduction)
        scores = cv2.matchTemplate(window, picture, cv2.TM_CCOEFF_NORMED)
        _, ncc, _, place = cv2.minMaxLoc(scores)
        step = extent / window.shape[1::-1]
        in_window = np.array(place) + (np.array(picture.shape[1::-1]) - 1.0) / 2.0
        return float(ncc), corner + (in_window + 0.5) * step - 0.5


def _resized(picture: np.ndarray, size: np.ndarray) -> np.ndarray:
    """The picture at the nearest whole (w, h), at least 4 px a side."""
    w, h = (max(4, round(float(side))) for side in size)
    if picture.shape == (h, w):
        return picture
    return cv2.resize(picture, (w, h), interpolation=cv2.INTER_AREA)
