"""Observation models: how probable an image is under a warp, and its linearisation.

Patches and template are normalised (zero mean, unit deviation) over the *visible* pixels, so the
mean squared residual is `2 (1 - ncc)`. R = sigma^2 I over hundreds of correlated pixels would put
all weight on one particle; the sum is tempered to an effective number of independent pixels. The
same R serves importance function and weights. A hidden pixel costs what an average visible pixel
costs, so warps are not rewarded for sliding under an occluder.
"""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tracker.affine import aff2
from tracker.affine.patches import Layers, PatchFit, PatchMatcher
from tracker.checks import require_positive

_DAMPING = 30.0
"""Added to the information of each direction: one that the template does not show stays put."""
_STEP_LIMIT = 0.3


class Observation(Protocol):
    """One image as the filter sees it."""

    def log_likelihood(self, warps: np.ndarray) -> np.ndarray:
        """(n,) log p(y | X), up to a constant."""
        ...

    def linearise(self, warps: np.ndarray, iteration: int = 0) -> tuple[np.ndarray, np.ndarray]:
        """Gradient J^T R^-1 r (n, 6) and information J^T R^-1 J (n, 6, 6) at `warps`.

        `iteration` counts the linearisations of one image; coarse pictures may come first.
        """
        ...


@dataclass(frozen=True)
class LikelihoodConfig:
    """Photometric noise model shared by all filters."""

    independent_pixel_count: float = 20.0
    """Pixels that the template is worth when its samples are correlated."""
    initial_sigma: float = 0.4
    """Residual deviation before anything was measured [template deviations]."""
    sigma_floor: float = 0.15
    """Smallest residual deviation the online estimate may reach."""
    sigma_ceiling: float = 0.9
    """Largest residual deviation the online estimate may reach."""
    sigma_memory: float = 0.9
    """Share of the old variance kept at each update of the online estimate."""
    huber_threshold: float = 2.5
    """Residuals beyond this many sigmas count linearly."""
    is_local_noise: bool = False
    """Linearise each particle under the noise that its own residual shows, if that is larger."""
    shape_std: float | None = 0.01
    """Deviation of log scale, aspect and shear from the known size; None: size unknown."""

    def __post_init__(self) -> None:
        require_positive(self, "independent_pixel_count", "initial_sigma", "huber_threshold")
        require_positive(self, "sigma_floor", "sigma_ceiling")
        if self.shape_std is not None:
            require_positive(self, "shape_std")
        if not 0.0 <= self.sigma_memory < 1.0:
            raise ValueError(f"sigma_memory must be in [0, 1), got {self.sigma_memory!r}")


class PhotometricNoise:
    """The deviation of the residuals, learnt from image to image."""

    def __init__(self, config: LikelihoodConfig) -> None:
        self._config = config
        self.sigma = config.initial_sigma
        """Present deviation [template deviations]."""

    def learn(self, ncc: float) -> None:
        """Takes in an image; the residual variance of normalised patches is 2 (1 - ncc)."""
        config = self._config
        share = config.sigma_memory
        variance = share * self.sigma**2 + (1.0 - share) * 2.0 * (1.0 - ncc)
        self.sigma = float(np.clip(math.sqrt(variance), config.sigma_floor, config.sigma_ceiling))


class TemplateObservation:
    """One grey image with visibility, compared with a template. [IGPF2021] Eq (10)."""

    def __init__(
        self,
        matcher: PatchMatcher,
        layers: Layers,
        config: LikelihoodConfig,
        sigma: float,
        unit_px: float | None = None,
    ) -> None:
        """Binds the image.

        Args:
            matcher: compares patches with what is looked for.
            layers: the image.
            config: noise model.
            sigma: current residual deviation.
            unit_px: known length of the template unit in the image [px]; None if unknown.
        """
        self._matcher = matcher
        self._layers = layers
        self._config = config
        self._sigma = sigma
        self._clip = config.huber_threshold * sigma
        self._known_shape: tuple[float, float] | None = None
        """Log of the unit [px] and variance of the shape, where the size is known."""
        if unit_px is not None and config.shape_std is not None:
            self._known_shape = float(np.log(unit_px)), config.shape_std**2

    def log_likelihood(self, warps: np.ndarray) -> np.ndarray:
        """(n,) tempered robust Gaussian log-likelihood. [IGPF2021] Eqs (10), (11)."""
        fit = self.fit(warps)
        visible = fit.visible_fraction
        hidden_cost = 0.5 * self._sigma**2
        cost = visible * fit.cost + (1.0 - visible) * hidden_cost
        result = -self._config.independent_pixel_count * cost / self._sigma**2
        return result + self._shape_log_likelihood(warps)

    def linearise(self, warps: np.ndarray, iteration: int = 0) -> tuple[np.ndarray, np.ndarray]:
        """Gradient (n, 6) and information (n, 6, 6), inverse compositional as in [Kwon2014]."""
        del iteration
        g, H, fit = self._matcher.linearise(self._layers, warps, self._clip)
        variance = self._sigma**2
        if self._config.is_local_noise:
            variance = np.maximum(variance, fit[:, 1])
        worth = self._config.independent_pixel_count * fit[:, 0] / variance
        g *= worth[:, None]
        H *= worth[:, None, None]
        return self._add_shape(warps, g, H)

    def fit(self, warps: np.ndarray) -> PatchFit:
        """Correlation, visibility and cost of each warp."""
        return self._matcher.fit(self._layers, warps, self._clip)

    def _shape_log_likelihood(self, warps: np.ndarray) -> np.ndarray | float:
        if self._known_shape is None:
            return 0.0
        log_unit, variance = self._known_shape
        return -0.5 * (_shape_error(warps, log_unit) ** 2).sum(axis=1) / variance

    def _add_shape(
        self, warps: np.ndarray, g: np.ndarray, H: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        if self._known_shape is not None:
            log_unit, variance = self._known_shape
            g[:, _SHAPE_AXES] -= _shape_error(warps, log_unit) / variance
            H[:, _SHAPE_AXES, _SHAPE_AXES] += 1.0 / variance
        return g, H


_SHAPE_AXES = [0, 1, 3]


def _shape_error(warps: np.ndarray, log_unit: float) -> np.ndarray:
    """(n, 3) log scale, aspect and shear relative to the known size."""
    error = aff2.polar(warps)[:, _SHAPE_AXES]
    error[:, 0] -= log_unit
    return error


def climb(observation: Observation, warps: np.ndarray, iterations: int) -> np.ndarray:
    """(k, 3, 3) warps moved to the nearest maxima of the likelihood, by Gauss-Newton steps."""
    for _ in range(iterations):
        gradient, information = observation.linearise(warps)
        damped = information + _DAMPING * np.eye(6)
        step = np.linalg.solve(damped, gradient[..., None])[..., 0]
        warps = aff2.perturb(warps, np.clip(np.nan_to_num(step), -_STEP_LIMIT, _STEP_LIMIT))
    return warps
