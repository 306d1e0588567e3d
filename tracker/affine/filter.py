"""The particle filter: PF, GPF and IGPF are this one loop with exchangeable parts.

`ParticleFilter.step` is [IGPF2021] Algorithm 1, one verb a line. A particle is the pair
(X_k, X_{k-1}), from which the autoregressive velocity of Eq (9) follows; here in seconds, so that a
dropped image does no harm.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias

import numpy as np

from tracker.affine import aff2
from tracker.affine.likelihood import Observation
from tracker.affine.proposal import Draw, GaussianProposal, PriorProposal, Proposal
from tracker.affine.resampling import RESAMPLERS, CombinationConfig, Particles, ResamplingContext
from tracker.affine.state_space import STATE_SPACES, moments
from tracker.base import WarpEstimate
from tracker.checks import require_choice, require_count, require_share


@dataclass(frozen=True)
class FilterConfig:
    """State equation, proposal and resampling of one particle filter."""

    state_space: Literal["group", "vector"] = "group"
    """Aff(2), or a vector of six affine parameters."""
    proposal: Literal["gaussian", "prior"] = "gaussian"
    """Gaussian importance function, or the transition prior."""
    resampling: str = "improved-gaussian"
    """Name in RESAMPLERS."""
    resampling_threshold: float = 1.0
    """Resample when ESS falls below this share of the particles; 1 means always."""
    particle_count: int = 150
    """Number of particles."""
    autoregression: float = 0.98
    """a of [IGPF2021] Eq (9): share of the velocity kept from image to image."""
    noise_per_root_s: tuple[float, ...] = (0.02, 0.02, 0.10, 0.02, 0.15, 0.15)
    """Process noise: scale, aspect, rotation [rad], shear, x, y [template units] per sqrt(s)."""
    iterations: int = 2
    """Linearisations of the Gaussian importance function per image."""
    prior_share: float = 0.1
    """Share of particles that the Gaussian proposal draws from the prior instead."""
    family_size: int = 1
    """Particles that share the linearisation of the first of them."""
    combination: CombinationConfig = field(default_factory=CombinationConfig)
    """Settings of the improved Gaussian resampling."""
    is_estimate_late: bool = False
    """Estimate from the resampled particles, the order of [IGPFPatent] step 6; it makes a
    difference only where resampling looks for better places."""

    def __post_init__(self) -> None:
        require_choice(self, "state_space", tuple(STATE_SPACES))
        require_choice(self, "proposal", ("gaussian", "prior"))
        require_choice(self, "resampling", tuple(RESAMPLERS))
        if self.proposal == "gaussian" and self.state_space == "vector":
            raise ValueError("proposal 'gaussian' needs state_space 'group', got 'vector'")
        require_count(self, "particle_count")
        require_share(self, "resampling_threshold", "autoregression")
        noise = np.asarray(self.noise_per_root_s, float)
        if noise.shape != (6,) or not (np.isfinite(noise).all() and (noise > 0).all()):
            raise ValueError(
                f"noise_per_root_s must be six positive numbers, got {self.noise_per_root_s!r}"
            )
        self.build_proposal()

    def build_proposal(self) -> Proposal:
        """The named proposal with its settings."""
        if self.proposal == "prior":
            return PriorProposal()
        return GaussianProposal(self.iterations, self.prior_share, self.family_size)


@dataclass(frozen=True, eq=False)
class FilterState:
    """What a filter carries from one image to the next."""

    particles: Particles
    step_s: float
    """Time between the two warps of each particle."""
    covariance: np.ndarray
    """(6, 6) of the last estimate."""


Collector: TypeAlias = Callable[[Particles, Particles], None]
"""Receives the particles before and after a resampling."""


class ParticleFilter:
    """Sequential importance resampling over warps."""

    def __init__(
        self,
        config: FilterConfig,
        rng: np.random.Generator,
        det_range: tuple[float, float] = (1e-3, 1e7),
    ) -> None:
        """Particles whose det A leaves `det_range` or that are not finite get no weight."""
        self._config = config
        self._rng = rng
        self._det_range = det_range
        self._space = STATE_SPACES[config.state_space]
        self._proposal = config.build_proposal()
        self._variance_rate = np.square(config.noise_per_root_s)
        self._state: FilterState | None = None
        self.collector: Collector | None = None
        """What is called at each resampling; None for nothing."""

    @property
    def particles(self) -> Particles:
        """The present particles; ValueError before `start`."""
        return self._present.particles

    @property
    def _present(self) -> FilterState:
        if self._state is None:
            raise ValueError("the filter holds no particles before start()")
        return self._state

    def start(
        self, warp: np.ndarray, previous_warp: np.ndarray | None = None, step_s: float = 1.0
    ) -> None:
        """Puts all particles at `warp`, with the velocity that led there from `previous_warp`.

        None means at rest, the paper's A_0 = 0; on a moving belt give two detections `step_s`
        apart, or the narrow importance function loses the target at once.
        """
        n = self._config.particle_count
        previous_warp = warp if previous_warp is None else previous_warp
        particles = Particles(
            warps=np.tile(warp, (n, 1, 1)).astype(float),
            previous=np.tile(previous_warp, (n, 1, 1)).astype(float),
            log_weights=np.full(n, -math.log(n)),
            log_likelihoods=np.zeros(n),
        )
        self._state = FilterState(particles, step_s, np.zeros((6, 6)))

    def step(
        self,
        observation: Observation | None,
        step_s: float,
        detections_px: np.ndarray | None = None,
    ) -> WarpEstimate:
        """Moves the particles to the next image and returns their moments. [IGPF2021] Algorithm 1.

        What the image says of the estimate (`ncc`, `visible_fraction`, `status`) is left open.

        Args:
            observation: the image; None where it cannot be used, and the particles only move.
            step_s: time since the last image.
            detections_px: (m, 2) places from which m particles start, whatever their own
                prediction: the detector's part of the transition in [Okuma2004].
        """
        predicted = self.predict(step_s)
        predicted = self._jump(predicted, detections_px)
        drawn = self._draw(predicted, observation, step_s)
        weighted, log_evidence = self._weigh(drawn, observation)
        resampled = self._resample(weighted, observation, step_s)
        warp, covariance = self._estimate(weighted, resampled)
        self._state = FilterState(resampled, step_s, covariance)
        particles = resampled.warps
        return WarpEstimate(warp, covariance, weighted.ess, log_evidence, particles=particles)

    def predict(self, step_s: float) -> np.ndarray:
        """(n, 3, 3) warps moved by their own velocity. [IGPF2021] Eqs (8), (9)."""
        now = self.particles
        share = self._config.autoregression * step_s / self._present.step_s
        moved = self._space.advance(now.previous, now.warps, share)
        is_valid = self._is_valid(moved)
        if is_valid.all():
            return moved
        heaviest = int(np.argmax(np.where(is_valid, now.log_weights, -np.inf)))
        stand_in = moved[heaviest] if is_valid[heaviest] else now.warps[heaviest]
        return _replaced(moved, is_valid, stand_in)

    def _jump(self, predicted: np.ndarray, detections_px: np.ndarray | None) -> np.ndarray:
        """Moves randomly chosen particles to the detections, one to each."""
        if detections_px is not None:
            jumping = self._rng.permutation(len(predicted))[: len(detections_px)]
            predicted[jumping, :2, 2] = detections_px
        return predicted

    def _draw(self, predicted: np.ndarray, observation: Observation | None, step_s: float) -> Draw:
        """Draws from the importance function; from the prior without an image. Eqs (18)-(23)."""
        variances = self._variance_rate * step_s
        if observation is None:
            return PriorProposal().draw(predicted, variances, None, self._space, self._rng)
        return self._proposal.draw(predicted, variances, observation, self._space, self._rng)

    def _weigh(self, drawn: Draw, observation: Observation | None) -> tuple[Particles, float]:
        """Particles with normalised weights, and the log evidence. [IGPF2021] Eq (11)."""
        now = self.particles
        if observation is None:
            particles = Particles(drawn.warps, now.warps, now.log_weights, now.log_likelihoods)
            return particles, -math.inf
        is_valid = self._is_valid(drawn.warps)
        warps = _replaced(drawn.warps, is_valid, now.warps[0])
        log_likelihoods = observation.log_likelihood(warps)
        log_weights = now.log_weights + log_likelihoods + drawn.log_ratio
        log_weights = np.where(is_valid & np.isfinite(log_weights), log_weights, -np.inf)
        log_weights, log_evidence = _normalised(log_weights)
        return Particles(warps, now.warps, log_weights, log_likelihoods), log_evidence

    def _resample(
        self, weighted: Particles, observation: Observation | None, step_s: float
    ) -> Particles:
        """Equally weighted particles, where the effective sample size asks for them."""
        threshold = self._config.resampling_threshold * weighted.count
        if observation is None or weighted.ess > threshold:
            return weighted
        context = ResamplingContext(
            space=self._space,
            observation=observation,
            covariance=self._present.covariance,
            variances=self._variance_rate * step_s,
            combination=self._config.combination,
        )
        resampled = RESAMPLERS[self._config.resampling](weighted, context, self._rng)
        if self.collector is not None:
            self.collector(weighted, resampled)
        return resampled

    def _estimate(self, weighted: Particles, resampled: Particles) -> tuple[np.ndarray, np.ndarray]:
        """Mean (3, 3) and covariance (6, 6) of the particles."""
        basis = resampled if self._config.is_estimate_late else weighted
        return moments(self._space, basis.warps, basis.weights)

    def _is_valid(self, warps: np.ndarray) -> np.ndarray:
        return aff2.is_valid(warps, self._det_range)


def _replaced(warps: np.ndarray, is_valid: np.ndarray, stand_in: np.ndarray) -> np.ndarray:
    """(n, 3, 3) copy of the warps with `stand_in` (3, 3) for those that are not valid."""
    return np.where(is_valid[:, None, None], warps, stand_in)


def _normalised(log_weights: np.ndarray) -> tuple[np.ndarray, float]:
    """Log weights (n,) of which the exponentials sum to one, and the log of the sum before.

    All weights are equal where each was zero.
    """
    peak = log_weights.max()
    if not np.isfinite(peak):
        return np.full(len(log_weights), -math.log(len(log_weights))), -math.inf
    log_sum = float(peak + np.log(np.exp(log_weights - peak).sum()))
    return log_weights - log_sum, log_sum


@dataclass(frozen=True)
class FilterMethod:
    """The exchangeable parts of one particle filter; each is a field of `FilterConfig`."""

    description: str
    """One line for listings."""
    state_space: Literal["group", "vector"]
    proposal: Literal["gaussian", "prior"]
    resampling: str

    def applied_to(self, config: FilterConfig) -> FilterConfig:
        """Returns `config` with the parts of this method; all other settings stay."""
        return replace(
            config, state_space=self.state_space, proposal=self.proposal, resampling=self.resampling
        )


METHODS: dict[str, FilterMethod] = {
    "igpf": FilterMethod(
        "particles on Aff(2), Gaussian proposal, improved Gaussian resampling",
        state_space="group",
        proposal="gaussian",
        resampling="improved-gaussian",
    ),
    "gpf": FilterMethod(
        "particles on Aff(2), Gaussian proposal, residual resampling",
        state_space="group",
        proposal="gaussian",
        resampling="residual",
    ),
    "pf": FilterMethod(
        "vector of affine parameters, transition prior, systematic resampling",
        state_space="vector",
        proposal="prior",
        resampling="systematic",
    ),
}
