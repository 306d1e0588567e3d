"""A particle filter on Aff(2) behind the interface of video trackers.

The template is cut from the first box, compared inside a window around the last estimate, and
follows slow changes. A correlation filter may guide, a lost target may be looked for, and the
estimate may be refined.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from tracker.affine import aff2
from tracker.affine.filter import Collector, FilterConfig, ParticleFilter
from tracker.affine.likelihood import LikelihoodConfig, PhotometricNoise, TemplateObservation
from tracker.affine.patches import Layers
from tracker.affine.resampling import CombinationConfig
from tracker.affine.template import Template
from tracker.base import Status
from tracker.box_tracker import BoxEstimate, box_of_warp, warp_of_box
from tracker.checks import require_positive, require_share
from tracker.video.appearance import Appearance, AppearanceConfig, Fit
from tracker.video.guide import Guidance, Guide, GuideConfig
from tracker.video.redetection import LossMonitor, RedetectionConfig, whole_image_response
from tracker.video.refinement import Refinement, RefinementConfig
from tracker.video.window import Window, WindowObservation, cut_window

_FRAME = 1.0
"""Step of the filter's clock: video benchmarks state no time, so noise rates are per image."""


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
    appearance: AppearanceConfig = field(default_factory=AppearanceConfig)
    guide: GuideConfig | None = None
    """A correlation filter beside the template; None: the template alone."""
    redetection: RedetectionConfig | None = None
    """How to find a lost target again; None: it is never given up, nor looked for."""
    refinement: RefinementConfig | None = None
    """How the filter's estimate is made exact; None: it is the answer."""
    reach: float = 2.5
    """Half a side of the window in template units."""
    tracking_ncc: float = 0.5
    """Correlation from which the tracker says that it tracks."""

    def __post_init__(self) -> None:
        require_positive(self, "reach")
        require_share(self, "tracking_ncc")
        levels = len(self.appearance.blurs)
        if levels > 1 and levels != self.filter.iterations:
            raise ValueError(
                f"{levels} blurs need as many iterations, got {self.filter.iterations}"
            )


@dataclass(frozen=True, eq=False)
class _View(WindowObservation):
    """Part of an image, as the appearances and perhaps a guide see it."""

    layers: list[Layers]
    """One for each appearance."""
    guidance: Guidance | None = None

    def log_likelihood(self, warps: np.ndarray) -> np.ndarray:
        value = super().log_likelihood(warps)
        return value if self.guidance is None else value + self.guidance.log_likelihood(warps)

    def confidence(self, warp: np.ndarray, ncc: float) -> float:
        """Confidence that the target is at `warp` (3, 3), 1 at best: the guide's score or `ncc`."""
        return ncc if self.guidance is None else float(self.guidance.scores(warp[None])[0])


class ParticleBoxTracker:
    """Cuts the template from the first box and follows it on Aff(2)."""

    def __init__(self, config: BoxTrackerConfig, rng: np.random.Generator) -> None:
        self._config = config
        self._rng = rng
        self._filter = ParticleFilter(config.filter, rng)
        self._noise = PhotometricNoise(config.likelihood)
        self._warp = np.eye(3)
        self._appearances: list[Appearance] = []
        self._guide: Guide | None = None
        self._loss: LossMonitor | None = None
        self._refinement: Refinement | None = None

    def collect_resamplings(self, collector: Collector) -> None:
        """Hands the particles before and after each resampling to `collector` from now on."""
        self._filter.collector = collector

    def start(self, image: np.ndarray, box: np.ndarray) -> None:
        """See `BoxTracker`."""
        config = self._config
        w, h = float(box[2]), float(box[3])
        if not (np.isfinite(box).all() and w >= 1 and h >= 1):
            raise ValueError(f"box must have an area, got {w:g} x {h:g} px")
        self._warp = warp_of_box(box)
        window = self._cut(image, self._warp[:2, 2])
        appearance = config.appearance
        self._appearances = [Appearance(appearance, blur, window, box) for blur in appearance.blurs]
        self._noise = PhotometricNoise(config.likelihood)
        self._filter.start(self._warp)
        if config.guide is not None:
            self._guide = Guide(config.guide, self._template.size, image, self._warp)
        if config.refinement is not None:
            self._refinement = Refinement(
                config.refinement, appearance, config.likelihood, window, box
            )
        if config.redetection is not None:
            self._loss = LossMonitor(config.redetection, self._warp)

    def update(self, image: np.ndarray) -> BoxEstimate:
        """See `BoxTracker`."""
        if not self._appearances:
            raise ValueError("update() before start()")
        view, places = self._everywhere(image) if self._is_lost else self._nearby(image)
        estimate = self._filter.step(view, _FRAME, places)
        if aff2.is_valid(estimate.warp):
            self._warp = estimate.warp
            if self._refinement is not None:
                self._warp = self._refinement.refine(view.window, self._warp, self._noise.sigma)
        fits = self._fits(view, self._warp)
        if self._loss is not None:
            self._loss.note(view.confidence(self._warp, fits[-1].ncc), self._warp)
        if self._loss is None or not self._loss.is_missed:
            self._learn(image, fits)
        fit = fits[-1]
        affine = replace(
            estimate,
            warp=self._warp,
            ncc=fit.ncc,
            visible_fraction=fit.visible_fraction,
            status=self._status(fit.ncc),
        )
        return BoxEstimate(box_of_warp(self._warp, self._template.size), affine)

    @property
    def _is_lost(self) -> bool:
        return self._loss is not None and self._loss.is_lost

    @property
    def _unit_px(self) -> float:
        """Present length of the template unit in the image."""
        return math.sqrt(abs(float(np.linalg.det(self._warp[:2, :2]))))

    @property
    def _template(self) -> Template:
        """The finest one."""
        return self._appearances[-1].matcher.template

    def _nearby(self, image: np.ndarray) -> tuple[_View, np.ndarray | None]:
        """What is seen around the last place, and where particles should start."""
        if self._guide is None:
            return self._look(image, self._warp[:2, 2]), None
        guidance = self._guide.search(image, self._warp)
        view = replace(self._look(image, guidance.best_px), guidance=guidance)
        return view, guidance.draw_places(self._config.filter.particle_count, self._rng)

    def _everywhere(self, image: np.ndarray) -> tuple[_View, np.ndarray | None]:
        """The same of the whole image, for the target as it was when it was last seen."""
        config = self._config.redetection
        assert config is not None
        assert self._loss is not None
        self._warp = self._loss.last_good_warp.copy()
        if self._guide is not None:
            self._warp[:2, 2] = self._guide.find(image, self._warp)
            self._filter.start(self._warp)
            return self._nearby(image)
        self._filter.start(self._warp)
        view = self._look(image, self._warp[:2, 2], everywhere=True)
        blur = self._config.appearance.blurs[-1]
        response = whole_image_response(
            image, self._template, blur, self._unit_px, config.resolution
        )
        count = round(config.share * self._config.filter.particle_count)
        return view, response.draw(count, config.sharpness, self._rng)

    def _cut(self, image: np.ndarray, centre_px: np.ndarray, everywhere: bool = False) -> Window:
        config = self._config
        reach = math.hypot(*image.shape[:2]) / self._unit_px if everywhere else config.reach
        return cut_window(image, centre_px, self._unit_px, reach, config.appearance.grid)

    def _look(self, image: np.ndarray, centre_px: np.ndarray, everywhere: bool = False) -> _View:
        """What the appearances see around a place, or everywhere."""
        window = self._cut(image, centre_px, everywhere)
        layers = [look.layers(window) for look in self._appearances]
        levels = tuple(
            TemplateObservation(look.matcher, each, self._config.likelihood, self._noise.sigma)
            for look, each in zip(self._appearances, layers, strict=True)
        )
        return _View(window, levels, layers)

    def _fits(self, view: _View, warp: np.ndarray) -> list[Fit]:
        """How each appearance matches under a warp (3, 3) of the image."""
        in_window = view.window.to_window @ warp
        pairs = zip(self._appearances, view.layers, strict=True)
        return [look.fit(layers, in_window) for look, layers in pairs]

    def _learn(self, image: np.ndarray, fits: Sequence[Fit]) -> None:
        """Learns the noise, the appearances and what else follows the target from an image."""
        self._noise.learn(fits[-1].ncc)
        for look, fit in zip(self._appearances, fits, strict=True):
            look.learn(fit)
        if self._refinement is not None:
            self._refinement.learn()
        if self._guide is not None:
            self._guide.learn(image, self._warp)

    def _status(self, ncc: float) -> Status:
        if self._is_lost:
            return Status.LOST
        return Status.TRACKING if ncc >= self._config.tracking_ncc else Status.UNCERTAIN
