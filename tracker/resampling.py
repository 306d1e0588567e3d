"""Turning weighted particles into equally weighted ones.

Every resampler has the signature `(particles, context, rng) -> Particles`. The first three copy
particles and are unbiased; the Gaussian ones place new warps and follow [IGPF2021] section 3.1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tracker.likelihood import Observation
from tracker.state_space import StateSpace


@dataclass(frozen=True, eq=False)
class Particles:
    """Weighted pairs of present and previous warps; the pair carries the velocity."""

    warps: np.ndarray
    """(n, 3, 3) at k."""
    previous: np.ndarray
    """(n, 3, 3) of the same particles at k - 1."""
    log_weights: np.ndarray
    """(n,) normalised: their exponentials sum to one."""
    log_likelihoods: np.ndarray
    """(n,) log p(y_k | X_k), the observation weight."""

    @property
    def count(self) -> int:
        """Number of particles."""
        return len(self.warps)

    @property
    def weights(self) -> np.ndarray:
        """(n,) weights that sum to one."""
        return np.exp(self.log_weights)

    @property
    def ess(self) -> float:
        """Effective sample size, from 1 to n."""
        return float(1.0 / np.sum(self.weights**2))


@dataclass(frozen=True, eq=False)
class ResamplingContext:
    """What a resampler may use beside the particles."""

    space: StateSpace
    observation: Observation
    covariance: np.ndarray
    """(6, 6) of the estimate one step ago, around which Gaussian resamplers spread."""
    step_gain: float = 0.5
    """K of [IGPF2021] Eq (24); the paper gives no value."""
    max_halvings: int = 3
    """Times the step L may be halved before a particle falls back to its parent."""


Resampler = Callable[[Particles, ResamplingContext, np.random.Generator], Particles]


def multinomial(p: Particles, context: ResamplingContext, rng: np.random.Generator) -> Particles:
    """Independent draws from the cumulative weights."""
    return _copies(p, multinomial_indices(p.weights, rng))


def systematic(p: Particles, context: ResamplingContext, rng: np.random.Generator) -> Particles:
    """One uniform offset, evenly spaced draws: the least noisy of the copies."""
    return _copies(p, systematic_indices(p.weights, rng))


def residual(p: Particles, context: ResamplingContext, rng: np.random.Generator) -> Particles:
    """floor(n w) sure copies, the rest multinomial on the remainders."""
    return _copies(p, residual_indices(p.weights, rng))


def gaussian(p: Particles, context: ResamplingContext, rng: np.random.Generator) -> Particles:
    """Multinomial parents, each copy spread by the covariance of the last estimate."""
    parents = multinomial_indices(p.weights, rng)
    return replace(_copies(p, parents), warps=_spread(p.warps[parents], context, rng))


def improved_gaussian(
    p: Particles, context: ResamplingContext, rng: np.random.Generator
) -> Particles:
    """Gaussian copies of high-weight particles, moved towards low-weight ones.

    `X_new = X_first exp(K L log(X_first^-1 X_min))`, accepted if its observation weight exceeds
    its parent's; otherwise L is halved, and at last the parent itself is kept.
    Source: [IGPF2021] Eqs (24), (25). The displayed equations are lost in the text at hand: the
    direction (towards X_min) and L = N^(-1/6) are our reading. The greedy acceptance makes the
    output concentrate on modes; it is a heuristic, not a sample of the posterior.
    """
    parents = multinomial_indices(p.weights, rng)
    first = _spread(p.warps[parents], context, rng)
    low = np.setdiff1d(np.arange(p.count), parents)
    if len(low) == 0:
        low = np.arange(p.count)
    partners = p.warps[rng.choice(low, size=p.count)]
    direction = context.space.difference(first, partners)
    step = context.step_gain * p.count ** (-1.0 / 6.0)
    warps, scores = p.warps[parents], p.log_likelihoods[parents]
    accepted_scores = scores.copy()
    open_ = np.flatnonzero(np.isfinite(direction).all(axis=1))
    for _ in range(context.max_halvings + 1):
        if len(open_) == 0:
            break
        trial = context.space.perturb(first[open_], step * direction[open_])
        trial_scores = context.observation.log_likelihood(trial)
        is_better = trial_scores > scores[open_]
        warps[open_[is_better]] = trial[is_better]
        accepted_scores[open_[is_better]] = trial_scores[is_better]
        open_ = open_[~is_better]
        step *= 0.5
    return replace(_copies(p, parents), warps=warps, log_likelihoods=accepted_scores)


RESAMPLERS: dict[str, Resampler] = {
    "multinomial": multinomial,
    "systematic": systematic,
    "residual": residual,
    "gaussian": gaussian,
    "improved-gaussian": improved_gaussian,
}


def multinomial_indices(weights: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """(n,) sorted parent indices, independent draws."""
    return _invert(weights, np.sort(rng.random(len(weights))))


def systematic_indices(weights: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """(n,) sorted parent indices, evenly spaced draws."""
    count = len(weights)
    return _invert(weights, (np.arange(count) + rng.random()) / count)


def residual_indices(weights: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """(n,) sorted parent indices: each particle at least floor(n w) times."""
    count = len(weights)
    expected = count * weights
    sure = np.floor(expected + 1e-9).astype(int)
    rest = count - int(sure.sum())
    draws = rng.random(count)[: max(rest, 0)]
    remainder = np.maximum(expected - sure, 0.0)
    indices = np.repeat(np.arange(count), sure)
    if rest > 0:
        indices = np.concatenate([indices, _invert(remainder / remainder.sum(), draws)])
    return np.sort(indices)[:count]


def _invert(weights: np.ndarray, u: np.ndarray) -> np.ndarray:
    cumulative = np.cumsum(weights)
    return np.searchsorted(cumulative / cumulative[-1], u, side="right").clip(0, len(weights) - 1)


def _copies(p: Particles, parents: np.ndarray) -> Particles:
    return Particles(
        warps=p.warps[parents],
        previous=p.previous[parents],
        log_weights=np.full(p.count, -np.log(p.count)),
        log_likelihoods=p.log_likelihoods[parents],
    )


def _spread(warps: np.ndarray, context: ResamplingContext, rng: np.random.Generator) -> np.ndarray:
    """Warps perturbed by N(0, C); C may be singular."""
    values, vectors = np.linalg.eigh(context.covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    e = rng.standard_normal((len(warps), 6)) @ root.T
    return context.space.perturb(warps, e)
