"""Turning weighted particles into equally weighted ones.

Every resampler has the signature `(particles, context, rng) -> Particles`. The first three copy
particles and are unbiased; the Gaussian ones place new warps and follow [IGPF2021] section 3.1.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from tracker.affine.likelihood import Observation
from tracker.affine.state_space import StateSpace
from tracker.checks import require_choice, require_count


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
    parents: np.ndarray | None = None
    """(n,) which particle each was before resampling; None before it."""

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


@dataclass(frozen=True)
class CombinationConfig:
    """How improved Gaussian resampling combines particles of high and of low weight.

    [IGPF2021] Eqs (24) and (25) are lost in the text at hand; the defaults are the readings that
    its words support best, and `docs/method.md` compares the others.
    """

    step_gain: float = 0.5
    """K of Eq (24); no value is given."""
    dimension: int = 6
    """dim of Eq (25), `L = N^(-1/dim)`: 6 for the state, 3 for a pose."""
    max_halvings: int = 2
    """Times L is halved before a particle falls back to its parent."""
    direction: Literal["towards-low", "away-from-low", "from-low"] = "towards-low"
    """From the Gaussian copy towards a low particle, away from it, or from the low particle
    towards the copy."""
    low: Literal["not-drawn", "below-average"] = "not-drawn"
    """The low particles: those that no draw chose, or [IGPFPatent] those below a threshold."""
    centre: Literal["parent", "best"] = "parent"
    """Each copy spreads around its own parent, or [IGPFPatent] all around the best particle."""
    spread: Literal["estimate", "prediction"] = "estimate"
    """The variance of the copies: that of the estimate one step ago, or what the state equation
    makes of it, with the process noise of the step."""

    def __post_init__(self) -> None:
        if not (math.isfinite(self.step_gain) and 0.0 <= self.step_gain <= 10.0):
            raise ValueError(f"step_gain must be a number from 0 to 10, got {self.step_gain!r}")
        require_count(self, "dimension")
        require_count(self, "max_halvings", least=0)
        require_choice(self, "direction", ("towards-low", "away-from-low", "from-low"))
        require_choice(self, "low", ("not-drawn", "below-average"))
        require_choice(self, "centre", ("parent", "best"))
        require_choice(self, "spread", ("estimate", "prediction"))


@dataclass(frozen=True, eq=False)
class ResamplingContext:
    """What a resampler may use beside the particles."""

    space: StateSpace
    observation: Observation
    covariance: np.ndarray
    """(6, 6) of the estimate one step ago."""
    variances: np.ndarray
    """(6,) of the process noise of this step."""
    combination: CombinationConfig = field(default_factory=CombinationConfig)


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
    """Gaussian copies of high-weight particles, combined with low-weight ones.

    `X_new = X_first exp(K L log(X_first^-1 X_min))` with `L = N^(-1/dim)`, accepted if its
    observation weight exceeds its parent's; otherwise L is halved, and at last the parent itself
    is kept. The greedy acceptance makes the output concentrate on modes; it is a heuristic, not a
    sample of the posterior. Source: [IGPF2021] Eqs (24), (25), in the reading of the context.
    """
    config, space = context.combination, context.space
    parents = multinomial_indices(p.weights, rng)
    is_at_best = config.centre == "best"
    centres = np.full(p.count, np.argmax(p.log_weights)) if is_at_best else parents
    first = _spread(p.warps[centres], context, rng)
    partners = p.warps[rng.choice(_low(p, parents, config), size=p.count)]
    start, end = (partners, first) if config.direction == "from-low" else (first, partners)
    direction = space.difference(start, end)
    step = config.step_gain * p.count ** (-1.0 / config.dimension)
    if config.direction == "away-from-low":
        step = -step
    warps, scores = p.warps[parents], p.log_likelihoods[parents]
    accepted_scores = scores.copy()
    open_ = np.flatnonzero(np.isfinite(direction).all(axis=1))
    for _ in range(config.max_halvings + 1):
        if len(open_) == 0:
            break
        trial = space.perturb(start[open_], step * direction[open_])
        trial_scores = context.observation.log_likelihood(trial)
        is_better = trial_scores > scores[open_]
        warps[open_[is_better]] = trial[is_better]
        accepted_scores[open_[is_better]] = trial_scores[is_better]
        open_ = open_[~is_better]
        step *= 0.5
    return replace(_copies(p, parents), warps=warps, log_likelihoods=accepted_scores)


def _low(p: Particles, parents: np.ndarray, config: CombinationConfig) -> np.ndarray:
    """Indices of the low-weight particles; all where none is low."""
    if config.low == "not-drawn":
        is_low = np.bincount(parents, minlength=p.count) == 0
    else:
        is_low = p.log_weights < -math.log(p.count)
    return np.flatnonzero(is_low) if is_low.any() else np.arange(p.count)


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
        parents=parents,
    )


def _spread(warps: np.ndarray, context: ResamplingContext, rng: np.random.Generator) -> np.ndarray:
    """Warps perturbed by N(0, C); C may be singular."""
    covariance = context.covariance
    if context.combination.spread == "prediction":
        covariance = covariance + np.diag(context.variances)
    values, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    e = rng.standard_normal((len(warps), 6)) @ root.T
    return context.space.perturb(warps, e)
