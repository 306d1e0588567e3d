"""Finding a lost target again: the template against the whole image.

A tracker that follows one mode cannot come back by itself. When the match has been poor for some
images, part of the particles start where the whole image looks like the template.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from tracker.checks import require_count, require_positive, require_share
from tracker.correlation import Response
from tracker.template import Template

_LEAST_SIDE_PX = 4


@dataclass(frozen=True)
class RedetectionConfig:
    """When a target counts as lost and how it is looked for."""

    lost_ncc: float = 0.3
    """Correlation below which an image counts as missed."""
    patience: int = 5
    """Missed images in a row after which the target is lost."""
    share: float = 0.5
    """Share of the particles of a lost target that start where the image looks like it."""
    sharpness: float = 20.0
    """Log-density of these places that a correlation of 1 is worth."""
    resolution: float = 16.0
    """Pixels to a template unit in the search; an image is never enlarged for it."""

    def __post_init__(self) -> None:
        require_share(self, "lost_ncc", "share")
        require_count(self, "patience")
        require_positive(self, "sharpness", "resolution")


class LossMonitor:
    """Counts poor matches in a row, and remembers the last good one."""

    def __init__(self, config: RedetectionConfig, warp: np.ndarray) -> None:
        """Begins with the target at `warp` (3, 3)."""
        self._config = config
        self._missed = 0
        self.last_good_warp = warp

    @property
    def is_lost(self) -> bool:
        """Whether the target was missed too often in a row."""
        return self._missed >= self._config.patience

    def note(self, ncc: float, warp: np.ndarray) -> None:
        """Takes the estimate (3, 3) in one image and the correlation there."""
        if ncc < self._config.lost_ncc:
            self._missed += 1
        else:
            self._missed, self.last_good_warp = 0, warp


def whole_image_response(
    image: np.ndarray, template: Template, blur: float, unit_px: float, resolution: float
) -> Response:
    """Correlation of an upright template with every place of a BGR image (h, w, 3).

    `blur` is how much the template was smoothed [template units], `unit_px` the length of the
    template unit in the image.
    """
    zoom = min(1.0, resolution / unit_px)
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    columns, rows = (max(1, round(side * zoom)) for side in grey.shape[::-1])
    small = cv2.resize(grey, (columns, rows), interpolation=cv2.INTER_AREA).astype(np.float32)
    zoom_x, zoom_y = columns / grey.shape[1], rows / grey.shape[0]
    small = cv2.GaussianBlur(small, (0, 0), blur * unit_px * zoom)
    width, height = (
        int(np.clip(round(side * unit_px * zoom), min(_LEAST_SIDE_PX, longest), longest))
        for side, longest in zip(template.size, (columns, rows), strict=True)
    )
    picture = template.values.reshape(template.shape)
    picture = cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA)
    scores = cv2.matchTemplate(small, picture, cv2.TM_CCOEFF_NORMED)
    scores = np.nan_to_num(scores, nan=0.0, posinf=0.0, neginf=0.0)
    x, y = 0.5 * width / zoom_x - 0.5, 0.5 * height / zoom_y - 0.5
    return Response(scores, np.array([[1 / zoom_x, 0, x], [0, 1 / zoom_y, y], [0, 0, 1.0]]))
