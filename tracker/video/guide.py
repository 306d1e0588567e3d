"""A correlation filter beside a particle filter: where to look, and how sure to be.

Particles start where its scores are high, and the scores enter the weights, as detections do in
boosted particle filters [Okuma2004]. Its window may turn with the target: a histogram of gradients
forgets what it has learnt within some 20 degrees.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from tracker.affine import aff2
from tracker.checks import require_positive, require_share
from tracker.video.correlation import CorrelationConfig, CorrelationFilter, ResponsePyramid

_LEAST_TURN_RAD = math.radians(3.0)
"""Turns that a histogram of gradients does not notice are not tried."""


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
    is_turning: bool = True
    """Whether the window turns with the target; if not it stays upright."""

    def __post_init__(self) -> None:
        require_share(self, "jump_share")
        require_positive(self, "resolution", "weight")


@dataclass(frozen=True, eq=False)
class Guidance:
    """What the guide says of one image."""

    response: ResponsePyramid
    config: GuideConfig

    @property
    def best_px(self) -> np.ndarray:
        """(2,) x and y of the largest score."""
        return self.response.best.peak_px

    def scores(self, warps: np.ndarray) -> np.ndarray:
        """(n,) of warps (n, 3, 3); 1 for the target as learnt."""
        return self.response.at(warps[:, :2, 2], _log_units(warps))

    def log_likelihood(self, warps: np.ndarray) -> np.ndarray:
        """(n,) what the scores add to the log-likelihood."""
        return self.config.weight * np.maximum(self.scores(warps), 0.0)

    def draw_places(self, particle_count: int, rng: np.random.Generator) -> np.ndarray:
        """(k, 2) pixels where some of the particles should start."""
        count = round(self.config.jump_share * particle_count)
        return self.response.best.draw(count, self.config.weight, rng)


class Guide:
    """Learns one target beside a particle filter."""

    def __init__(
        self, config: GuideConfig, size: tuple[float, float], image: np.ndarray, warp: np.ndarray
    ) -> None:
        """Learns the target at `warp` (3, 3); `size` is its width and height [template units]."""
        self._config = config
        self._turn_rad = 0.0
        self._filter = CorrelationFilter(config.correlation, size, config.resolution)
        self._filter.start(image, self._pose(warp))

    def search(self, image: np.ndarray, warp: np.ndarray) -> Guidance:
        """Looks around the last warp (3, 3).

        The window takes the turn of the warp if the target then scores higher: what particles know
        of a turn that means nothing, as that of a walker's, would only blur what is learnt.
        """
        response = self._filter.search(image, self._pose(warp))
        turn_rad = float(aff2.polar(warp)[2])
        by_rad = math.remainder(turn_rad - self._turn_rad, math.tau)
        if self._config.is_turning and abs(by_rad) > _LEAST_TURN_RAD:
            turned = _pose(warp, turn_rad)
            if self._filter.respond(image, turned).peak > response.middle.peak:
                self._turn_rad = turn_rad
                response = self._filter.search(image, turned)
        return Guidance(response, self._config)

    def find(self, image: np.ndarray, warp: np.ndarray) -> np.ndarray:
        """(2,) pixels where the whole image looks most like the target in the size of `warp`."""
        return self._filter.respond_everywhere(image, self._pose(warp)).peak_px

    def learn(self, image: np.ndarray, warp: np.ndarray) -> None:
        """Adds the view of the target at `warp` (3, 3)."""
        self._filter.learn(image, self._pose(warp))

    def _pose(self, warp: np.ndarray) -> np.ndarray:
        return _pose(warp, self._turn_rad)


def _pose(warp: np.ndarray, turn_rad: float) -> np.ndarray:
    """(3, 3) similarity with place and size of a warp, but another turn."""
    return aff2.similarity(math.exp(aff2.polar(warp)[0]), turn_rad, warp[:2, 2])


def _log_units(warps: np.ndarray) -> np.ndarray:
    """(n,) logarithm of the template unit under warps (n, 3, 3) [px]."""
    A = warps[:, :2, :2]
    det = A[:, 0, 0] * A[:, 1, 1] - A[:, 0, 1] * A[:, 1, 0]
    return 0.5 * np.log(np.maximum(det, 1e-12))
