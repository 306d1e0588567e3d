"""A particle filter on the warp of a template in overhead images, with its photometric noise."""

import math

import cv2
import numpy as np

from tracker.affine import aff2
from tracker.affine.filter import ParticleFilter
from tracker.affine.likelihood import PhotometricNoise, TemplateObservation
from tracker.affine.patches import Layers, PatchMatcher
from tracker.affine.template import Template
from tracker.base import Status, WarpEstimate
from tracker.belt.detection import Sighting
from tracker.belt.image import Window
from tracker.belt.rectify import OverheadImage
from tracker.belt.registry import TrackerConfig

_MIN_STEP_S = 1e-4
_RESERVE, _RESERVE_PER_S = 0.5, 5.0
"""Width of the strip around the predicted target that is looked at, in template units, at once
and by the time since the last image: a target may have been stopped or pushed meanwhile."""


class FilterFollower:
    """A `Follower` whose filter gets its velocity from two sightings."""

    def __init__(
        self, config: TrackerConfig, template: Template, unit_px: float, rng: np.random.Generator
    ) -> None:
        """`unit_px` is the length of the template unit in the overhead image."""
        self._filter = ParticleFilter(config.filter, rng)
        self._likelihood = config.likelihood
        self._status_config = config.status
        self._unit_px = unit_px
        self._blur_px = template.smoothing_px(unit_px)
        self._matcher = PatchMatcher(template)
        self._noise = PhotometricNoise(config.likelihood)
        self._shape_px = (0, 0)
        self._time_s = -math.inf
        self._unsupported_s = 0.0
        self._misses = 0

    def start(self, image: OverheadImage, now: Sighting, before: Sighting) -> None:
        """See `Follower`."""
        step_s = max(now.time_s - before.time_s, _MIN_STEP_S)
        self._filter.start(now.found.warp, before.found.warp, step_s)
        self._noise = PhotometricNoise(self._likelihood)
        self._shape_px = image.grey.shape
        self._time_s = now.time_s
        self._unsupported_s = 0.0
        self._misses = 0

    def region(self, time_s: float) -> Window | None:
        """Where a particle may come to lie, and a reserve for what prediction does not know."""
        age_s = self._age_s(time_s)
        corners = self._filter.predict(age_s)[:, :2] @ self._matcher.template.corners
        if not np.isfinite(corners).all():
            return None
        reserve_px = self._unit_px * (_RESERVE + _RESERVE_PER_S * age_s)
        low = np.floor(corners.min(axis=(0, 2)) - reserve_px)
        high = np.ceil(corners.max(axis=(0, 2)) + reserve_px) + 1.0
        rows, columns = self._shape_px
        (left, top), (right, bottom) = np.clip([low, high], 0, [columns, rows]).astype(int)
        return slice(top, bottom), slice(left, right)

    def update(self, image: OverheadImage, time_s: float) -> WarpEstimate:
        """See `Follower`; an unusable image only moves the particles."""
        step_s = self._age_s(time_s)
        self._time_s = time_s
        if not _is_usable(image.grey):
            return self._coast(step_s)
        observation = self._observe(image)
        estimate = self._filter.step(observation, step_s)
        if not aff2.is_valid(estimate.warp):
            return self._coast(step_s)
        fit = observation.fit(estimate.warp[None])
        ncc, visible = float(fit.ncc[0]), float(fit.visible_fraction[0])
        status = self._judge(ncc, visible, step_s)
        if status is Status.TRACKING:
            self._noise.learn(ncc)
        return estimate.judged(ncc, visible, status)

    def _age_s(self, time_s: float) -> float:
        """Time from the last image to `time_s`."""
        return max(time_s - self._time_s, _MIN_STEP_S)

    def _observe(self, image: OverheadImage) -> TemplateObservation:
        """The image bound to the template under the present noise estimate."""
        layers = Layers.of(cv2.GaussianBlur(image.grey, (0, 0), self._blur_px), image.visibility)
        return TemplateObservation(
            self._matcher, layers, self._likelihood, self._noise.sigma, self._unit_px
        )

    def _coast(self, step_s: float) -> WarpEstimate:
        """Moves the particles without an image."""
        estimate = self._filter.step(None, step_s)
        return estimate.judged(0.0, 0.0, self._judge(0.0, 0.0, step_s))

    def _judge(self, ncc: float, visible: float, step_s: float) -> Status:
        config = self._status_config
        is_judgeable = visible >= config.min_visible_fraction
        if is_judgeable and ncc >= config.tracking_ncc:
            self._unsupported_s, self._misses = 0.0, 0
            return Status.TRACKING
        self._unsupported_s += step_s
        self._misses = self._misses + 1 if is_judgeable and ncc < config.lost_ncc else 0
        is_lost = self._misses >= config.lost_image_count
        if is_lost or self._unsupported_s > config.max_hidden_s:
            return Status.LOST
        return Status.UNCERTAIN


def _is_usable(image: np.ndarray) -> bool:
    """True if the image is a finite 2-D picture that is not uniformly dark."""
    if image.ndim != 2 or min(image.shape) < 2 or not np.isfinite(image[::8, ::8]).all():
        return False
    return float(image[::4, ::4].std()) > 0.5
