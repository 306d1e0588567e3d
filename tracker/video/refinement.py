"""Refines the filter's estimate to the nearest maximum of the likelihood, under less blur.

A few hundred particles on six dimensions leave their noise in the mean, and what blur they need to
find the target hides what would place it exactly.
"""

from dataclasses import dataclass

import numpy as np

from tracker.affine import aff2
from tracker.affine.likelihood import LikelihoodConfig, TemplateObservation, climb
from tracker.checks import require_count, require_positive
from tracker.video.appearance import Appearance, AppearanceConfig, Fit
from tracker.video.window import Window, WindowObservation


@dataclass(frozen=True)
class RefinementConfig:
    """How an estimate is made exact."""

    steps: int = 4
    """Gauss-Newton steps from the filter's estimate."""
    blur: float = 0.03
    """Deviation of the Gaussian that smooths window and template [template units]."""

    def __post_init__(self) -> None:
        require_count(self, "steps")
        require_positive(self, "blur")


class Refinement:
    """A sharper template beside those of the filter."""

    def __init__(
        self,
        config: RefinementConfig,
        appearance: AppearanceConfig,
        likelihood: LikelihoodConfig,
        window: Window,
        box: np.ndarray,
    ) -> None:
        """Cuts the template from `box` (x, y, w, h) [px] of the image that `window` shows."""
        self._steps = config.steps
        self._likelihood = likelihood
        self._look = Appearance(appearance, config.blur, window, box)
        self._fit: Fit | None = None

    def refine(self, window: Window, warp: np.ndarray, sigma: float) -> np.ndarray:
        """The warp (3, 3) of the image where the template fits best, near that of the filter.

        It counts only if the template fits better there. `sigma` is the deviation of residuals.
        """
        layers = self._look.layers(window)
        inner = TemplateObservation(self._look.matcher, layers, self._likelihood, sigma)
        observation = WindowObservation(window, (inner,))
        refined = climb(observation, warp[None], self._steps)[0]
        fit = self._look.fit(layers, window.to_window @ warp)
        if aff2.is_valid(refined):
            better = self._look.fit(layers, window.to_window @ refined)
            if better.ncc > fit.ncc:
                warp, fit = refined, better
        self._fit = fit
        return warp

    def learn(self) -> None:
        """Follows what the last image showed."""
        if self._fit is not None:
            self._look.learn(self._fit)
