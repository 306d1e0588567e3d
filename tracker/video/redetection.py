"""Detection of a loss, and of the lost target in the whole image.

A tracker that follows one mode cannot come back by itself, and what it learns of an image without
the target it does not forget. What a confident match scores differs from target to target; so it
is compared with its own average.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from tracker.affine.template import Template
from tracker.checks import require_count, require_positive, require_share
from tracker.video.correlation import Response

_LEAST_SIDE_PX = 4


@dataclass(frozen=True)
class RedetectionConfig:
    """When a target counts as lost and how it is looked for."""

    missed_share: float = 0.4
    """Share of its average below which the confidence in an image says: not there."""
    found_share: float = 0.6
    """Share of its average from which a lost target counts as found again."""
    patience: int = 5
    """Missed images in a row after which the target is lost."""
    memory: float = 0.95
    """Share of the old average kept with each image that shows the target."""
    share: float = 0.5
    """Share of the particles of a lost target that start where the image looks like it."""
    sharpness: float = 20.0
    """Log-density of these places that a correlation of 1 is worth."""
    resolution: float = 16.0
    """Pixels to a template unit in the search; an image is never enlarged for it."""

    def __post_init__(self) -> None:
        require_share(self, "missed_share", "found_share", "memory", "share")
        require_count(self, "patience")
        require_positive(self, "sharpness", "resolution")


class LossMonitor:
    """Counts poor matches in a row, and remembers the last good one."""

    def __init__(self, config: RedetectionConfig, warp: np.ndarray) -> None:
        """Begins with the target at `warp` (3, 3)."""
        self._config = config
        self._missed = 0
        self._average: float | None = None
        self.last_good_warp = warp

    @property
    def is_missed(self) -> bool:
        """Whether the last image did not show the target."""
        return self._missed > 0

    @property
    def is_lost(self) -> bool:
        """Whether the target was missed too often in a row."""
        return self._missed >= self._config.patience

    def note(self, confidence: float, warp: np.ndarray) -> None:
        """Takes the estimate (3, 3) in one image and how well it matches there, 1 at best."""
        config = self._config
        average = confidence if self._average is None else self._average
        share = config.found_share if self.is_lost else config.missed_share
        if confidence < share * average:
            self._missed += 1
            return
        self._missed, self.last_good_warp = 0, warp
        self._average = config.memory * average + (1.0 - config.memory) * confidence


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
