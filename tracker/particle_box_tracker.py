"""A particle filter on Aff(2) behind the interface of video trackers.

The template is cut from the first box, compared inside a window around the last estimate, and
follows slow changes. A correlation filter may guide: some particles then start where its scores are
high, and the scores enter the weights, as detections do in boosted particle filters [Okuma2004].
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import cv2
import numpy as np

from tracker import aff2
from tracker.base import Status, WarpEstimate
from tracker.box_tracker import BoxEstimate, box_of_warp, warp_of_box
from tracker.correlation import CorrelationConfig, CorrelationFilter, ResponsePyramid
from tracker.filter import FilterConfig, FilterEstimate, ParticleFilter
from tracker.likelihood import LikelihoodConfig, TemplateObservation
from tracker.matching import Layers, PatchMatcher
from tracker.resampling import CombinationConfig
from tracker.template import Template
from tracker.window import Window, WindowObservation, cut_window

_FRAME = 1.0
"""Step of the filter's clock: video benchmarks tell no time, so noise rates are per image."""


@dataclass(frozen=True)
class GuideConfig:
    """How much a correlation filter decides."""

    correlation: CorrelationConfig = field(default_factory=CorrelationConfig)
    resolution: float = 32.0
    """Pixels to a template unit in the correlation filter's window."""
    jump_share: float = 0.5
    """Share of particles that start where the scores send them, not from their own prediction."""
    weight: float = 75.0
    """Log-likelihood that a score of 1 is worth, and sharpness of the places drawn."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.jump_share <= 1.0:
            raise ValueError(f"jump_share must be in [0, 1], got {self.jump_share!r}")
        for name in ("resolution", "weight"):
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) > 0):
                raise ValueError(f"{name} must be a positive number, got {getattr(self, name)!r}")


VIDEO_FILTER = FilterConfig(
    particle_count=200,
    autoregression=0.5,
    noise_per_root_s=(0.015, 0.005, 0.02, 0.005, 0.16, 0.16),
    iterations=1,
    prior_share=0.0,
    combination=CombinationConfig(max_halvings=3, spread="prediction"),
    is_estimate_late=True,
)
"""The steps of [IGPF2021] Algorithm 1 and no more; noise rates are per image."""
VIDEO_LIKELIHOOD = LikelihoodConfig(initial_sigma=0.5, sigma_floor=0.2, shape_std=None)
"""For targets of unknown size."""


@dataclass(frozen=True)
class BoxTrackerConfig:
    """A particle filter for targets of unknown size and motion."""

    description: str
    """One line for listings."""
    filter: FilterConfig = VIDEO_FILTER
    likelihood: LikelihoodConfig = VIDEO_LIKELIHOOD
    guide: GuideConfig | None = None
    """A correlation filter beside the template; None: the template alone."""
    grid: int = 32
    """Rows and columns of template samples; also the window's pixels to a template unit."""
    reach: float = 2.5
    """Half a side of the window in template units."""
    blur: float = 0.1
    """Deviation of the Gaussian that smooths window and template [template units]."""
    update_rate: float = 0.02
    """Share of a well matched new patch in the running average of the template."""
    anchor: float = 0.0
    """Share of the first picture in the template, against drift; the average has the rest."""
    update_ncc: float = 0.5
    """Correlation from which a patch counts as well matched."""
    tracking_ncc: float = 0.5
    """Correlation from which the tracker says that it tracks."""

    def __post_init__(self) -> None:
        if self.grid < 4:
            raise ValueError(f"grid must be 4 or greater, got {self.grid}")
        for name in ("reach", "blur"):
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) > 0):
                raise ValueError(f"{name} must be a positive number, got {getattr(self, name)!r}")
        for name in ("update_rate", "anchor", "update_ncc", "tracking_ncc"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise ValueError(f"{name} must be in [0, 1], got {getattr(self, name)!r}")


class ParticleBoxTracker:
    """Cuts the template from the first box and follows it on Aff(2)."""

    def __init__(self, config: BoxTrackerConfig, rng: np.random.Generator) -> None:
        self._config = config
        self._rng = rng
        self._filter = ParticleFilter(config.filter, rng)
        self._sigma = config.likelihood.initial_sigma
        self._warp = np.eye(3)
        self._matcher: PatchMatcher | None = None
        self._first: Template | None = None
        self._average = np.zeros(0)
        self._correlation: CorrelationFilter | None = None

    def start(self, image: np.ndarray, box: np.ndarray) -> None:
        """See `BoxTracker`."""
        w, h = float(box[2]), float(box[3])
        if not (np.isfinite(box).all() and w >= 1 and h >= 1):
            raise ValueError(f"box must have an area, got {w:g} x {h:g} px")
        self._warp = warp_of_box(box)
        window, _ = self._look(image, self._warp[:2, 2])
        grid = (self._config.grid, self._config.grid)
        self._first = Template.of_samples(_samples(window, box, grid), (w, h), texture_std=1.0)
        self._average = self._first.values.copy()
        self._matcher = PatchMatcher(self._first)
        self._sigma = self._config.likelihood.initial_sigma
        self._filter.start(self._warp)
        if self._config.guide is not None:
            guide = self._config.guide
            size = self._matcher.template.size
            self._correlation = CorrelationFilter(guide.correlation, size, guide.resolution)
            self._correlation.start(image, self._warp[:2, 2], self._unit_px)

    def update(self, image: np.ndarray) -> BoxEstimate:
        """See `BoxTracker`."""
        if self._matcher is None:
            raise ValueError("update() before start()")
        response = self._respond(image)
        centre = self._warp[:2, 2] if response is None else response.best.peak_px
        window, layers = self._look(image, centre)
        template = TemplateObservation(self._matcher, layers, self._config.likelihood, self._sigma)
        observation = WindowObservation(template, window.to_window)
        if response is None:
            estimate = self._filter.step(observation, _FRAME)
        else:
            estimate = self._guided_step(observation, response)
        if aff2.is_valid(estimate.warp):
            self._warp = estimate.warp
        patch, visible = self._matcher.patch(layers, window.to_window @ self._warp)
        visible_fraction = float(visible.mean())
        ncc = _correlation(self._matcher.template.values, patch, visible)
        self._learn(ncc, patch, visible_fraction)
        if self._correlation is not None:
            self._correlation.learn(image, self._warp[:2, 2], self._unit_px)
        return self._report(estimate, ncc, visible_fraction)

    @property
    def _unit_px(self) -> float:
        """Present length of the template unit in the image."""
        return math.sqrt(abs(float(np.linalg.det(self._warp[:2, :2]))))

    def _look(self, image: np.ndarray, centre_px: np.ndarray) -> tuple[Window, Layers]:
        config = self._config
        window = cut_window(image, centre_px, self._unit_px, config.reach, config.grid)
        smooth = cv2.GaussianBlur(window.grey, (0, 0), config.blur * config.grid)
        return Window(smooth, window.to_window), Layers.of(smooth)

    def _respond(self, image: np.ndarray) -> ResponsePyramid | None:
        if self._correlation is None:
            return None
        return self._correlation.search(image, self._warp[:2, 2], self._unit_px)

    def _guided_step(
        self, observation: WindowObservation, response: ResponsePyramid
    ) -> FilterEstimate:
        guide = self._config.guide
        assert guide is not None
        guided = _GuidedObservation(observation, response, guide.weight)
        count = round(guide.jump_share * self._config.filter.particle_count)
        places = response.best.draw(count, guide.weight, self._rng)
        return self._filter.step(guided, _FRAME, places)

    def _learn(self, ncc: float, patch: np.ndarray, visible_fraction: float) -> None:
        """Noise from the residual, 2 (1 - ncc) of normalised patches; template from the patch."""
        config, likelihood = self._config, self._config.likelihood
        share = likelihood.sigma_memory
        variance = share * self._sigma**2 + (1.0 - share) * 2.0 * (1.0 - ncc)
        sigma = math.sqrt(variance)
        self._sigma = float(np.clip(sigma, likelihood.sigma_floor, likelihood.sigma_ceiling))
        assert self._first is not None
        if ncc >= config.update_ncc and visible_fraction > 0.8 and config.update_rate > 0:
            self._average += config.update_rate * (patch - self._average)
            self._matcher = PatchMatcher(self._first.blended(self._average, 1.0 - config.anchor))

    def _report(self, estimate: FilterEstimate, ncc: float, visible: float) -> BoxEstimate:
        assert self._matcher is not None
        is_supported = ncc >= self._config.tracking_ncc
        affine = WarpEstimate(
            warp=self._warp,
            covariance=estimate.covariance,
            ess=estimate.ess,
            log_likelihood=estimate.log_evidence,
            ncc=ncc,
            visible_fraction=visible,
            status=Status.TRACKING if is_supported else Status.UNCERTAIN,
            particles=self._filter.particles.warps,
            resampling=estimate.resampling,
        )
        return BoxEstimate(box_of_warp(self._warp, self._matcher.template.size), affine)


@dataclass(frozen=True, eq=False)
class _GuidedObservation:
    """An observation whose likelihood also counts the correlation filter's scores."""

    inner: WindowObservation
    response: ResponsePyramid
    weight: float

    def log_likelihood(self, warps: np.ndarray) -> np.ndarray:
        scores = np.maximum(self.response.at(warps[:, :2, 2], _log_units(warps)), 0.0)
        return self.inner.log_likelihood(warps) + self.weight * scores

    def linearise(self, warps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self.inner.linearise(warps)


def _log_units(warps: np.ndarray) -> np.ndarray:
    """(n,) logarithm of the template unit under warps (n, 3, 3) [px]."""
    A = warps[:, :2, :2]
    det = A[:, 0, 0] * A[:, 1, 1] - A[:, 0, 1] * A[:, 1, 0]
    return 0.5 * np.log(np.maximum(det, 1e-12))


def _samples(window: Window, box: np.ndarray, grid: tuple[int, int]) -> np.ndarray:
    """(rows, columns) values of the window on a grid over the box."""
    rows, columns = grid
    x, y, w, h = (float(v) for v in box)
    left, top = x - 0.5 + 0.5 * w / columns, y - 0.5 + 0.5 * h / rows
    step = np.array([[w / columns, 0, left], [0, h / rows, top], [0, 0, 1.0]])
    return cv2.warpAffine(
        window.grey,
        (window.to_window @ step)[:2],
        (columns, rows),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )


def _correlation(template: np.ndarray, patch: np.ndarray, visible: np.ndarray) -> float:
    """Correlation of normalised values over the visible samples; 0 where none is."""
    count = float(visible.sum())
    if count < 1:
        return 0.0
    return float(np.clip((visible * template * patch).sum() / count, -1.0, 1.0))
