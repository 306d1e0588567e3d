"""The particle filter: PF, GPF and IGPF are this one loop with exchangeable parts.

Source: [IGPF2021] Algorithm 1. A particle is the pair (X_k, X_{k-1}), from which the
autoregressive velocity of Eq (9) follows; here in seconds, so that a dropped image does no harm.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from tracker.affine import aff2
from tracker.affine.likelihood import Observation
from tracker.affine.proposal import GaussianProposal, PriorProposal, Proposal
from tracker.affine.resampling import RESAMPLERS, CombinationConfig, Particles, ResamplingContext
from tracker.affine.state_space import STATE_SPACES, moments
from tracker.base import ResamplingTrace
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
class FilterEstimate:
    """Moments of the particles after one image."""

    warp: np.ndarray
    """(3, 3) weighted mean on the state space."""
    covariance: np.ndarray
    """(6, 6) weighted covariance in the tangent space at `warp`."""
    ess: float
    """Effective sample size."""
    log_evidence: float
    """Log of the mean unnormalised weight; -inf when no particle explains the image."""
    resampling: ResamplingTrace | None = None
    """None where nothing was resampled."""


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
        self._resample = RESAMPLERS[config.resampling]
        self._variance_rate = np.square(config.noise_per_root_s)
        self._particles: Particles | None = None
        self._step_s = 1.0
        self._covariance = np.zeros((6, 6))

    @property
    def particles(self) -> Particles:
        """The present particles; ValueError before `start`."""
        if self._particles is None:
            raise ValueError("the filter holds no particles before start()")
        return self._particles

    def start(
        self, warp: np.ndarray, previous_warp: np.ndarray | None = None, step_s: float = 1.0
    ) -> None:
        """Puts all particles at `warp`, with the velocity that led there from `previous_warp`.

        None means at rest, the paper's A_0 = 0; on a moving belt give two detections `step_s`
        apart, or the narrow importance function loses the target at once.
        """
        n = self._config.particle_count
        previous_warp = warp if previous_warp is None else previous_warp
        self._particles = Particles(
            warps=np.tile(warp, (n, 1, 1)).astype(float),
            previous=np.tile(previous_warp, (n, 1, 1)).astype(float),
            log_weights=np.full(n, -math.log(n)),
            log_likelihoods=np.zeros(n),
        )
        self._step_s = step_s
        self._covariance = np.zeros((6, 6))

    def step(
        self,
        observation: Observation,
        step_s: float,
        detections_px: np.ndarray | None = None,
    ) -> FilterEstimate:
        """Moves, weighs, estimates and resamples.

        Args:
            observation: the image.
            step_s: time since the last image.
            detections_px: (m, 2) places from which m particles start, whatever their own
                prediction: the detector's part of the transition in [Okuma2004].
        """
        predicted = self.predict(step_s)
        if detections_px is not None:
            jumping = self._rng.permutation(len(predicted))[: len(detections_px)]
            predicted[jumping, :2, 2] = detections_px
        variances = self._variance_rate * step_s
        draw = self._proposal.draw(predicted, variances, observation, self._space, self._rng)
        particles, log_evidence = self._weigh(draw.warps, draw.log_ratio, observation)
        resampled = self._resampled(particles, observation, variances)
        basis = resampled if self._config.is_estimate_late else particles
        warp, covariance = moments(self._space, basis.warps, basis.weights)
        self._particles = resampled
        self._step_s = step_s
        self._covariance = covariance
        trace = None
        if resampled.parents is not None:
            trace = ResamplingTrace(particles.warps, particles.weights, resampled.parents)
        return FilterEstimate(warp, covariance, particles.ess, log_evidence, trace)

    def coast(self, step_s: float) -> FilterEstimate:
        """Moves the particles through an image that cannot be used."""
        predicted = self.predict(step_s)
        e = self._rng.standard_normal((len(predicted), 6))
        e *= np.sqrt(self._variance_rate * step_s)
        particles = Particles(
            warps=self._space.perturb(predicted, e),
            previous=self.particles.warps,
            log_weights=self.particles.log_weights,
            log_likelihoods=self.particles.log_likelihoods,
        )
        warp, covariance = moments(self._space, particles.warps, particles.weights)
        self._particles = particles
        self._step_s = step_s
        self._covariance = covariance
        return FilterEstimate(warp, covariance, particles.ess, -math.inf)

    def predict(self, step_s: float) -> np.ndarray:
        """(n, 3, 3) warps moved by their own velocity. [IGPF2021] Eqs (8), (9)."""
        now = self.particles
        share = self._config.autoregression * step_s / self._step_s
        moved = self._space.advance(now.previous, now.warps, share)
        is_good = self._is_good(moved)
        if is_good.all():
            return moved
        heaviest = int(np.argmax(np.where(is_good, now.log_weights, -np.inf)))
        moved[~is_good] = moved[heaviest] if is_good.any() else now.warps[heaviest]
        return moved

    def _weigh(
        self, warps: np.ndarray, log_ratio: np.ndarray, observation: Observation
    ) -> tuple[Particles, float]:
        """Particles with normalised weights, and the log evidence. [IGPF2021] Eq (11)."""
        is_good = self._is_good(warps)
        stand_in = self.particles.warps[0]
        if not is_good.all():
            warps = np.where(is_good[:, None, None], warps, stand_in)
        log_likelihoods = observation.log_likelihood(warps)
        log_weights = self.particles.log_weights + log_likelihoods + log_ratio
        log_weights = np.where(is_good & np.isfinite(log_weights), log_weights, -np.inf)
        peak = log_weights.max()
        if not np.isfinite(peak):
            log_evidence = -math.inf
            log_weights = np.full(len(warps), -math.log(len(warps)))
        else:
            log_evidence = float(peak + np.log(np.exp(log_weights - peak).sum()))
            log_weights = log_weights - log_evidence
        return Particles(warps, self.particles.warps, log_weights, log_likelihoods), log_evidence

    def _resampled(
        self, particles: Particles, observation: Observation, variances: np.ndarray
    ) -> Particles:
        threshold = self._config.resampling_threshold * particles.count
        if particles.ess > threshold:
            return particles
        context = ResamplingContext(
            space=self._space,
            observation=observation,
            covariance=self._covariance,
            variances=variances,
            combination=self._config.combination,
        )
        return self._resample(particles, context, self._rng)

    def _is_good(self, warps: np.ndarray) -> np.ndarray:
        return aff2.is_valid(warps, self._det_range)
