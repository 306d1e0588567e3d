"""What follows the target through the overhead images once it was found.

A particle filter, nothing at all (the control arm `static`), or a tracker of boxes. A box has no
rotation, and the target's size is known from the camera: so a box moves the warp of the detection
by the motion of its centre, while a tracker that knows an affine warp moves it by that.
"""

import math
from dataclasses import replace
from typing import Protocol

import cv2
import numpy as np

from tracker.affine import aff2
from tracker.affine.filter import ParticleFilter
from tracker.affine.likelihood import PhotometricNoise, TemplateObservation
from tracker.affine.patches import Layers, PatchMatcher
from tracker.affine.template import Template
from tracker.base import Status, WarpEstimate
from tracker.belt.detection import Detection, Sighting
from tracker.belt.image import Window
from tracker.belt.rectify import OverheadImage
from tracker.belt.registry import StatusConfig, TrackerConfig
from tracker.box_tracker import box_of_warp, warp_of_box
from tracker.peers.box_finder import HoldingTracker
from tracker.peers.outside import get_box_finder

_SIGHTED_STD = 0.02
"""Deviation of a warp that comes without a covariance, along each axis of the algebra."""
_MIN_STEP_S = 1e-4
_RESERVE, _RESERVE_PER_S = 0.5, 5.0
"""Width of the strip around the predicted target that is looked at, in template units, at once
and by the time since the last image: a target may have been stopped or pushed meanwhile."""


class Follower(Protocol):
    """Follows a target that was found."""

    def start(self, image: OverheadImage, now: Sighting, before: Sighting) -> None:
        """Takes the target where it was sighted in `image`, having been sighted `before`."""
        ...

    def region(self, time_s: float) -> Window | None:
        """Rows and columns of the overhead image that the next `update` looks at; None for all."""
        ...

    def update(self, image: OverheadImage, time_s: float) -> WarpEstimate:
        """The target in the next image."""
        ...


def make_follower(
    config: TrackerConfig, template: Template, unit_px: float, rng: np.random.Generator
) -> Follower:
    """The follower of a configuration; `unit_px` is the template unit in the overhead image."""
    if config.is_static:
        return StaticFollower()
    if config.baseline:
        tracker = get_box_finder(config.baseline).make(rng)
        return BoxFollower(tracker, template, config.status)
    return FilterFollower(config, template, unit_px, rng)


class StaticFollower:
    """Holds the sighting."""

    def start(self, image: OverheadImage, now: Sighting, before: Sighting) -> None:
        """See `Follower`."""
        del image, before
        self._held = sighted(now.found)

    def region(self, time_s: float) -> Window | None:
        """See `Follower`."""
        del time_s
        return None

    def update(self, image: OverheadImage, time_s: float) -> WarpEstimate:
        """See `Follower`."""
        del image, time_s
        return self._held


class BoxFollower:
    """A tracker of boxes as it is: it knows neither what is hidden nor how fast things are."""

    def __init__(self, tracker: HoldingTracker, template: Template, status: StatusConfig) -> None:
        self._tracker = tracker
        self._template = template
        self._status_config = status
        self._refused: WarpEstimate | None = None
        self._warp, self._start_warp, self._target_in_box = np.eye(3), np.eye(3), np.eye(3)
        self._found_s, self._misses = 0.0, 0

    def start(self, image: OverheadImage, now: Sighting, before: Sighting) -> None:
        """See `Follower`."""
        del before
        self._refused = None
        try:
            self._tracker.start(_colour(image), box_of_warp(now.found.warp, self._template.size))
        except ValueError:
            self._refused = replace(sighted(now.found), status=Status.LOST)
            return
        self._warp = now.found.warp
        self._start_warp = warp_of_box(self._tracker.box)
        self._target_in_box = aff2.inverse(self._start_warp) @ now.found.warp
        self._found_s, self._misses = now.time_s, 0

    def region(self, time_s: float) -> Window | None:
        """All: a tracker of boxes looks where it likes."""
        del time_s
        return None

    def update(self, image: OverheadImage, time_s: float) -> WarpEstimate:
        """See `Follower`."""
        if self._refused is not None:
            return self._refused
        is_found = bool(image.visibility.any()) and self._follow(image)
        visible = _visible_fraction(image, self._template, self._warp)
        status = self._judge(is_found, visible, time_s)
        return replace(sighted(Detection(self._warp, 0.0, visible)), status=status)

    def _follow(self, image: OverheadImage) -> bool:
        """Moves the warp with the tracker; whether it found the target."""
        estimate = self._tracker.update(_colour(image))
        if estimate.affine is not None:
            box_warp = estimate.affine.warp
        else:
            box_warp = self._start_warp.copy()
            box_warp[:2, 2] = estimate.box[:2] + (estimate.box[2:] - 1.0) / 2.0
        self._warp = box_warp @ self._target_in_box
        return self._tracker.is_found

    def _judge(self, is_found: bool, visible_fraction: float, time_s: float) -> Status:
        """The tracker's own word, with the patience that a filter gets."""
        config = self._status_config
        if is_found:
            self._found_s, self._misses = time_s, 0
            return Status.TRACKING
        if visible_fraction >= config.min_visible_fraction:
            self._misses += 1
        is_hidden_long = time_s - self._found_s > config.max_hidden_s
        is_lost = self._misses >= config.lost_image_count or is_hidden_long
        return Status.LOST if is_lost else Status.UNCERTAIN


def sighted(found: Detection) -> WarpEstimate:
    """A detection as an estimate."""
    return WarpEstimate(
        warp=found.warp,
        covariance=np.eye(6) * _SIGHTED_STD**2,
        ncc=found.ncc,
        visible_fraction=found.visible_fraction,
        status=Status.TRACKING,
    )


def _colour(image: OverheadImage) -> np.ndarray:
    return cv2.cvtColor(image.grey, cv2.COLOR_GRAY2BGR)


def _visible_fraction(image: OverheadImage, template: Template, warp: np.ndarray) -> float:
    """Share of the template's samples that lie in the image and are not hidden."""
    column, row = (warp[:2] @ template.points).astype(np.float32)
    visible = cv2.remap(image.visibility, column, row, cv2.INTER_NEAREST, borderValue=0)
    return float(np.count_nonzero(visible)) / visible.size


class FilterFollower:
    """A particle filter on the warp of the template, with its photometric noise.

    It gets its velocity from two sightings.
    """

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
        fit = observation.fit(np.array([estimate.warp]))
        ncc, visible = float(fit.ncc[0]), float(fit.visible_fraction[0])
        status = self._judge(ncc, visible, step_s)
        if status is Status.TRACKING:
            self._noise.learn(ncc)
        return replace(estimate, ncc=ncc, visible_fraction=visible, status=status)

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
        return replace(estimate, status=self._judge(0.0, 0.0, step_s))

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
