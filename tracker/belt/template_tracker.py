"""A `Tracker`: the particle filter, its photometric noise and an honest status."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from tracker.affine import aff2
from tracker.affine.filter import FilterConfig, FilterEstimate, ParticleFilter
from tracker.affine.likelihood import LikelihoodConfig, TemplateObservation
from tracker.affine.matching import Layers, PatchMatcher
from tracker.affine.template import Template
from tracker.base import Status, WarpEstimate
from tracker.checks import require_count, require_positive, require_share

_MIN_STEP_S = 1e-4


@dataclass(frozen=True)
class StatusConfig:
    """When a tracker trusts itself."""

    tracking_ncc: float = 0.75
    """Correlation from which the image supports the estimate."""
    lost_ncc: float = 0.45
    """Correlation under which a well visible target is not where the estimate says."""
    lost_image_count: int = 3
    """Images in a row under `lost_ncc` until the target counts as lost."""
    min_visible_fraction: float = 0.25
    """Visible share of the template under which the correlation proves nothing."""
    max_hidden_s: float = 1.0
    """Time without support by the image after which the target counts as lost."""

    def __post_init__(self) -> None:
        require_share(self, "tracking_ncc", "lost_ncc", "min_visible_fraction")
        if self.lost_ncc > self.tracking_ncc:
            raise ValueError(f"lost_ncc must not exceed tracking_ncc, got {self.lost_ncc!r}")
        require_count(self, "lost_image_count")
        require_positive(self, "max_hidden_s")


class TemplateTracker:
    """Follows a template in grey images with a particle filter on warps."""

    def __init__(
        self,
        template: Template,
        filter_config: FilterConfig,
        likelihood: LikelihoodConfig,
        status: StatusConfig,
        rng: np.random.Generator,
        unit_px: float | None = None,
    ) -> None:
        """`unit_px` is the known length of the template unit in the image; None if unknown."""
        self._filter = ParticleFilter(filter_config, rng)
        self._likelihood = likelihood
        self._status_config = status
        self._unit_px = unit_px
        self._blur_px = template.smoothing_px(unit_px) if unit_px else 0.0
        self._matcher = PatchMatcher(template)
        self._sigma = likelihood.initial_sigma
        self._time_s = -math.inf
        self._unsupported_s = 0.0
        self._misses = 0

    def start(
        self,
        warp: np.ndarray,
        time_s: float,
        previous_warp: np.ndarray | None = None,
        previous_time_s: float = 0.0,
    ) -> None:
        """Puts the filter at `warp`; a previous warp gives it a velocity."""
        step_s = 1.0 if previous_warp is None else max(time_s - previous_time_s, _MIN_STEP_S)
        self._filter.start(warp, previous_warp, step_s)
        self._sigma = self._likelihood.initial_sigma
        self._time_s = time_s
        self._unsupported_s = 0.0
        self._misses = 0

    def age_s(self, time_s: float) -> float:
        """Time from the last image to `time_s`."""
        return max(time_s - self._time_s, _MIN_STEP_S)

    def predicted_corners(self, time_s: float) -> np.ndarray:
        """(4 n, 2) corners of the template under the particles moved on to `time_s` [px]."""
        predicted = self._filter.predict(self.age_s(time_s))
        return (predicted[:, :2] @ self._matcher.template.corners).transpose(0, 2, 1).reshape(-1, 2)

    def update(
        self, image: np.ndarray, time_s: float, visibility: np.ndarray | None = None
    ) -> WarpEstimate:
        """Estimates the warp in `image` (h, w); an unusable image only moves the particles."""
        step_s = self.age_s(time_s)
        self._time_s = time_s
        if not _is_usable(image):
            return self._unseen(self._filter.coast(step_s), step_s)
        observation = self.observe(image, visibility)
        estimate = self._filter.step(observation, step_s)
        if not aff2.is_valid(estimate.warp):
            return self._unseen(self._filter.coast(step_s), step_s)
        fit = observation.fit(estimate.warp[None])
        ncc, visible = float(fit.ncc[0]), float(fit.visible_fraction[0])
        status = self._judge(ncc, visible, step_s)
        if status is Status.TRACKING:
            self._learn_sigma(ncc)
        return self._report(estimate, ncc, visible, status)

    def observe(self, image: np.ndarray, visibility: np.ndarray | None) -> TemplateObservation:
        """The image bound to the template under the present noise estimate."""
        smooth = cv2.GaussianBlur(image, (0, 0), self._blur_px) if self._blur_px else image
        layers = Layers.of(smooth, visibility)
        return TemplateObservation(
            self._matcher, layers, self._likelihood, self._sigma, self._unit_px
        )

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

    def _unseen(self, estimate: FilterEstimate, step_s: float) -> WarpEstimate:
        return self._report(estimate, 0.0, 0.0, self._judge(0.0, 0.0, step_s))

    def _learn_sigma(self, ncc: float) -> None:
        """Residual variance of normalised patches is 2 (1 - ncc)."""
        config = self._likelihood
        share = config.sigma_memory
        variance = share * self._sigma**2 + (1.0 - share) * 2.0 * (1.0 - ncc)
        self._sigma = float(np.clip(math.sqrt(variance), config.sigma_floor, config.sigma_ceiling))

    def _report(
        self, estimate: FilterEstimate, ncc: float, visible: float, status: Status
    ) -> WarpEstimate:
        return WarpEstimate(
            warp=estimate.warp,
            covariance=estimate.covariance,
            ess=estimate.ess,
            log_likelihood=estimate.log_evidence,
            ncc=ncc,
            visible_fraction=visible,
            status=status,
            particles=self._filter.particles.warps,
            resampling=estimate.resampling,
        )


def _is_usable(image: np.ndarray) -> bool:
    """True if the image is a finite 2-D picture that is not uniformly dark."""
    if image.ndim != 2 or min(image.shape) < 2 or not np.isfinite(image[::8, ::8]).all():
        return False
    return float(image[::4, ::4].std()) > 0.5
