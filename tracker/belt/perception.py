"""From RGB-D images to the target's pose: the patent's 2-D tracking and 3-D reconstruction.

searching --two consistent detections--> tracking <--> uncertain --> lost --> searching.

A target that comes into view is found while a part of it is still outside, and then at low
resolution beside its true place. So a track counts as unconfirmed until a detection clear of the
image's border agrees with it; one that finds a better match elsewhere starts the track anew.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from tracker.affine import aff2
from tracker.affine.template import Template
from tracker.base import Status, WarpEstimate
from tracker.belt.backproject import Backprojector, TargetPose
from tracker.belt.detection import Detection, Sighting, TemplateDetector
from tracker.belt.followers import make_follower, sighted
from tracker.belt.image import CameraImage
from tracker.belt.rectify import OverheadImage, OverheadView
from tracker.belt.registry import TrackerConfig

_MAX_DETECTION_GAP_S = 0.25
_MAX_DETECTION_TURN_RAD = 0.35
_CLEARANCE = 1.5
"""A target grown by this factor lies in the image when it is clear of the border."""
_CHECK_EVERY = 3
"""Images from one attempt to confirm a track to the next."""
_AGREEMENT = 0.15
"""Two places of the target are the same if they are no further apart, in template units."""


@dataclass(frozen=True, eq=False)
class TargetObservation:
    """What the tracker reports of the target after one image."""

    pose: TargetPose | None
    """Pose of the target; None while searching, and when the image or the estimate gave no pose."""
    estimate: WarpEstimate | None
    """Warp in the overhead image; None while searching."""
    status: Status
    """State after this image."""
    corners_px: np.ndarray = field(default_factory=lambda: np.empty((0, 2)))
    """(4, 2) corners of the target in the camera image, for drawing; may be empty."""
    particles_px: np.ndarray = field(default_factory=lambda: np.empty((0, 2)))
    """(n, 2) particle centres in the camera image, for drawing; may be empty."""
    is_correction: bool = False
    """Whether the track begins anew because what was followed before was not the target."""


class TargetTracker:
    """Finds and follows one object on a horizontal plane with a calibrated RGB-D camera."""

    def __init__(
        self,
        config: TrackerConfig,
        template: Template,
        size_m: tuple[float, float],
        view: OverheadView,
        rng: np.random.Generator,
    ) -> None:
        """Prepares detector and filter.

        Args:
            config: a row of TRACKERS.
            template: the target's top face, seen from above: u along its long axis (object +x),
                v against object +y.
            size_m: width (along u) and height (along v) of the top face.
            view: overhead view built from the camera's K and T_world_camera.
            rng: the only source of randomness.
        """
        if len(size_m) != 2 or not (np.isfinite(size_m).all() and min(size_m) > 0):
            raise ValueError(f"size_m must be two positive numbers, got {size_m!r}")
        self._config = config
        self._view = view
        self._corners = template.corners
        self._unit_px = math.sqrt(size_m[0] * size_m[1]) / view.m_per_px
        self._detector = TemplateDetector(template, self._unit_px, view.shape_px, config.detection)
        self._follower = make_follower(config, template, self._unit_px, rng)
        self._backprojector = Backprojector(template, view, config.backproject)
        self._status = Status.SEARCHING
        self._sighting: Sighting | None = None
        self._time_s = -math.inf
        self._is_confirmed, self._is_disproved, self._checked_ago = False, False, 0

    @property
    def status(self) -> Status:
        """State after the last image."""
        return self._status

    def update(self, image: CameraImage) -> TargetObservation:
        """Processes one image; bad input makes the status uncertain or lost, never raises.

        The time of exposure must grow from call to call.
        """
        time_s = image.time_s
        if not (math.isfinite(time_s) and time_s > self._time_s):
            return self._no_news()
        self._time_s = time_s
        if self._status in (Status.SEARCHING, Status.LOST):
            return self._search(self._view.rectify(image), time_s)
        overhead = self._view.rectify(image, self._follower.region(time_s))
        estimate = self._follower.update(overhead, time_s)
        if self._has_left(estimate.warp):
            estimate = replace(estimate, status=Status.LOST)
        self._status = estimate.status
        if estimate.status is Status.LOST:
            self._sighting = None
        elif self._is_refuted(estimate, image):
            return TargetObservation(None, None, self._status)
        return self._report(estimate, overhead, time_s)

    def _search(self, image: OverheadImage, time_s: float) -> TargetObservation:
        """Looks for the target; follows it from the second of two consistent sightings."""
        self._status = Status.SEARCHING
        found = self._detect(image)
        if found is None:
            return TargetObservation(None, None, self._status)
        now = Sighting(found, time_s)
        first, self._sighting = self._sighting, now
        if first is None or not self._is_same(first, now):
            return TargetObservation(None, None, self._status)
        self._backprojector.reset()
        self._follower.start(image, now, first)
        self._status = Status.TRACKING
        is_correction, self._is_disproved = self._is_disproved, False
        self._is_confirmed, self._checked_ago = self._config.is_static, 0
        report = self._report(sighted(found), image, time_s)
        return replace(report, is_correction=is_correction)

    def _detect(self, image: OverheadImage) -> Detection | None:
        return self._detector.detect(image.grey, image.visibility, image.height_m)

    def _is_refuted(self, estimate: WarpEstimate, image: CameraImage) -> bool:
        """Confirms the track, or drops it for a better match somewhere else."""
        self._checked_ago += 1
        is_due = not self._is_confirmed and self._checked_ago >= _CHECK_EVERY
        if not (is_due and estimate.status is Status.TRACKING and self._is_clear(estimate.warp)):
            return False
        self._checked_ago = 0
        found = self._detect(self._view.rectify(image))
        if found is None:
            return False
        self._is_confirmed = _is_near(found.warp, estimate.warp, _AGREEMENT)
        if self._is_confirmed or found.ncc <= estimate.ncc:
            return False
        self._status, self._is_disproved = Status.SEARCHING, True
        self._sighting = Sighting(found, image.time_s)
        return True

    def _is_clear(self, warp: np.ndarray) -> bool:
        """Whether the target, and half of its size more, lies in the camera's image."""
        grown = self._corners * [[_CLEARANCE], [_CLEARANCE], [1.0]]
        q = self._view.camera_of_pixel((warp @ grown)[:2].T)
        height, width = self._view.image_shape_px
        return bool((q >= 0).all() and (q <= [width - 1, height - 1]).all())

    def _is_same(self, first: Sighting, now: Sighting) -> bool:
        gap_s = now.time_s - first.time_s
        reach = self._config.max_speed_mps * gap_s / (self._view.m_per_px * self._unit_px)
        return gap_s <= _MAX_DETECTION_GAP_S and _is_near(first.found.warp, now.found.warp, reach)

    def _report(
        self, estimate: WarpEstimate, image: OverheadImage, time_s: float
    ) -> TargetObservation:
        pose = None
        if estimate.status is not Status.LOST:
            pose = self._backprojector.pose(estimate, image, self._unit_px, time_s)
        centres = estimate.particles[:, :2, 2]
        return TargetObservation(
            pose=pose,
            estimate=estimate,
            status=estimate.status,
            corners_px=self._view.camera_of_pixel((estimate.warp @ self._corners)[:2].T),
            particles_px=self._view.camera_of_pixel(centres),
        )

    def _has_left(self, warp: np.ndarray) -> bool:
        rows, columns = self._view.shape_px
        column, row = warp[:2, 2]
        return not (0 <= column < columns and 0 <= row < rows)

    def _no_news(self) -> TargetObservation:
        """Answer to an image without a valid new time."""
        if self._status is Status.TRACKING:
            return TargetObservation(None, None, Status.UNCERTAIN)
        return TargetObservation(None, None, self._status)


def _is_near(first: np.ndarray, second: np.ndarray, reach: float) -> bool:
    """Whether two warps are no further apart than `reach` [template units], nor much turned."""
    away = aff2.difference(first, second)
    return bool(np.hypot(away[4], away[5]) <= reach and abs(away[2]) <= _MAX_DETECTION_TURN_RAD)
