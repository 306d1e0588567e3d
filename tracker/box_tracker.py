"""A particle filter behind the interface of video trackers: a box on the first image, boxes after.

Boxes are (x, y, w, h) in pixels, x and y of the upper left corner counted from 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Protocol

import cv2
import numpy as np

from tracker.base import WarpEstimate
from tracker.filter import FilterConfig
from tracker.likelihood import LikelihoodConfig
from tracker.template import Template
from tracker.template_tracker import StatusConfig, TemplateTracker

FRAME_S = 1.0 / 30.0
"""Time between images; video benchmarks do not tell, and the noise rates are meant for this."""


@dataclass(frozen=True, eq=False)
class BoxEstimate:
    """Where a tracker believes its target to be on one image."""

    box: np.ndarray
    """(4,) x, y, w, h [px]; the last known one where the target is not found."""
    affine: WarpEstimate | None = None
    """What a tracker of warps knows beyond the box: the warp from template coordinates (origin at
    the centre of the first box, unit sqrt(w h) of it) to pixels, its covariance, its particles."""


class BoxTracker(Protocol):
    """Follows one target through a video."""

    def start(self, image: np.ndarray, box: np.ndarray) -> None:
        """Takes the target in `box` (4,) of the BGR `image` (h, w, 3).

        Raises ValueError where there is nothing to track: no area, no texture.
        """
        ...

    def update(self, image: np.ndarray) -> BoxEstimate:
        """The target in the next BGR image (h, w, 3)."""
        ...


@dataclass(frozen=True)
class BoxTrackerConfig:
    """A particle filter for targets of unknown size and motion."""

    filter: FilterConfig = field(
        default_factory=lambda: FilterConfig(
            noise_per_root_s=(0.08, 0.03, 0.11, 0.03, 0.55, 0.55), particle_count=200
        )
    )
    likelihood: LikelihoodConfig = field(default_factory=lambda: LikelihoodConfig(shape_std=None))
    status: StatusConfig = field(default_factory=StatusConfig)
    sample_count: int = 1024
    """Template samples; rows and columns follow the target's shape."""

    def __post_init__(self) -> None:
        if self.sample_count < 64:
            raise ValueError(f"sample_count must be 64 or greater, got {self.sample_count}")


class TemplateBoxTracker:
    """Cuts the template from the first box and follows it on Aff(2)."""

    def __init__(self, config: BoxTrackerConfig, rng: np.random.Generator) -> None:
        self._config = config
        self._rng = rng
        self._tracker: TemplateTracker | None = None
        self._size = (0.0, 0.0)
        self._time_s = 0.0

    def start(self, image: np.ndarray, box: np.ndarray) -> None:
        """See `BoxTracker`."""
        grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        x, y, w, h = (float(v) for v in box)
        picture = _cut(grey, x, y, w, h)
        rows = math.sqrt(self._config.sample_count * h / w)
        grid = max(4, round(rows)), max(4, round(self._config.sample_count / rows))
        template = Template.of_picture(picture, (w, h), grid)
        config = self._config
        self._tracker = TemplateTracker(
            template, config.filter, config.likelihood, config.status, self._rng
        )
        unit = math.sqrt(w * h)
        warp = np.array([[unit, 0, x + (w - 1) / 2], [0, unit, y + (h - 1) / 2], [0, 0, 1.0]])
        self._tracker.start(warp, 0.0)
        self._size, self._time_s = template.size, 0.0

    def update(self, image: np.ndarray) -> BoxEstimate:
        """See `BoxTracker`."""
        if self._tracker is None:
            raise ValueError("update() before start()")
        self._time_s += FRAME_S
        grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        estimate = self._tracker.update(grey, self._time_s)
        return BoxEstimate(box_of_warp(estimate.warp, self._size), estimate)


def box_of_warp(warp: np.ndarray, size: tuple[float, float]) -> np.ndarray:
    """(4,) axis-aligned box of the ellipse that the warped template inscribes.

    Unlike the box of the corners it does not grow with a rotation; for an unrotated template, or
    one turned by a right angle, it is the box of the corners.
    """
    extent = np.linalg.norm(warp[:2, :2] * size, axis=1)
    return np.concatenate([warp[:2, 2] - (extent - 1.0) / 2.0, extent])


def _cut(grey: np.ndarray, x: float, y: float, w: float, h: float) -> np.ndarray:
    """The picture inside the box; pixels beyond the image repeat its edge."""
    if not (math.isfinite(x + y + w + h) and w >= 1 and h >= 1):
        raise ValueError(f"box must have an area, got {w:g} x {h:g} px")
    columns = np.arange(round(x), round(x + w)).clip(0, grey.shape[1] - 1)
    rows = np.arange(round(y), round(y + h)).clip(0, grey.shape[0] - 1)
    picture = grey[np.ix_(rows, columns)]
    if min(picture.shape) < 4:
        picture = cv2.resize(picture, None, fx=4, fy=4, interpolation=cv2.INTER_LINEAR)
    return picture
