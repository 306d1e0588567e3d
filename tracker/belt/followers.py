"""What follows the target through the overhead images once it was found.

A particle filter, nothing at all (the control arm `static`), or a tracker of boxes. A box has no
rotation, and the target's size is known from the camera: so a box moves the warp of the detection
by the motion of its centre, while a tracker that knows an affine warp moves it by that.
"""

from dataclasses import replace
from typing import Protocol

import cv2
import numpy as np

from tracker.affine import aff2
from tracker.affine.template import Template
from tracker.base import Status, WarpEstimate
from tracker.belt.detection import Detection, Sighting
from tracker.belt.filter_follower import FilterFollower
from tracker.belt.image import Window
from tracker.belt.rectify import OverheadImage
from tracker.belt.registry import TrackerConfig
from tracker.belt.status import StatusConfig
from tracker.box_tracker import box_of_warp, warp_of_box
from tracker.peers.box_finder import HoldingTracker
from tracker.peers.outside import get_box_finder

_SIGHTED_STD = 0.02
"""Deviation of a warp that comes without a covariance, along each axis of the algebra."""


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
        ess=1.0,
        log_likelihood=0.0,
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
