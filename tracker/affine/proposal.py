"""Where new particles are drawn: the transition prior, or the Gaussian importance function.

Both return warps with `log p(X_k | X_{k-1}) - log q(X_k | X_{k-1}, y_k)`, the part of the weight of
[IGPF2021] Eq (11) that the likelihood does not give.
"""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from tracker.affine import gaussian_loops
from tracker.affine.likelihood import Observation
from tracker.affine.state_space import StateSpace
from tracker.checks import require_count

_STEP_LIMIT = 0.5
"""Longest Gauss-Newton step: farther out a linearisation means nothing."""


@dataclass(frozen=True, eq=False)
class Draw:
    """New particles and the log ratio of prior to proposal density."""

    warps: np.ndarray
    """(n, 3, 3) particles."""
    log_ratio: np.ndarray
    """(n,) log of the prior density less that of the proposal density."""


@dataclass(frozen=True)
class PriorProposal:
    """The transition density itself: the image is not consulted (CONDENSATION)."""

    def draw(
        self,
        predicted: np.ndarray,
        variances: np.ndarray,
        observation: Observation | None,
        space: StateSpace,
        rng: np.random.Generator,
    ) -> Draw:
        """Perturbs each of `predicted` (n, 3, 3) by noise of `variances` (6,); the ratio is one."""
        del observation
        e = rng.standard_normal((len(predicted), 6)) * np.sqrt(variances)
        return Draw(space.perturb(predicted, e), np.zeros(len(predicted)))


@dataclass(frozen=True)
class GaussianProposal:
    """Gaussian importance function on Aff(2), linearised at the image.

    The moments of [IGPF2021] Eqs (20)-(23) in information form, `Sigma = (Q^-1 + J^T R^-1 J)^-1`,
    iterated as in [Kwon2014]. A share of the particles may come from the prior (defensive
    mixture); all are then weighted by the mixture density, with the det Jr terms that densities
    on a non-unimodular group need.
    """

    iterations: int = 2
    """Linearisations per image (Gauss-Newton steps)."""
    prior_share: float = 0.1
    """Share of particles drawn from the transition prior, from 0 to below 1."""
    family_size: int = 1
    """One particle in so many, a parent, consults the image; the next ones, its children, take
    over its linearisation and keep their own prior. [Kwon2014] parent-child particles."""

    def __post_init__(self) -> None:
        require_count(self, "iterations", "family_size")
        if not 0.0 <= self.prior_share < 1.0:
            raise ValueError(f"prior_share must be in [0, 1), got {self.prior_share!r}")

    def draw(
        self,
        predicted: np.ndarray,
        variances: np.ndarray,
        observation: Observation,
        space: StateSpace,
        rng: np.random.Generator,
    ) -> Draw:
        """Draws from the local posterior of each of `predicted` (n, 3, 3).

        Its process noise has `variances` (6,). [IGPF2021] Eqs (21)-(23).
        """
        del space
        count = len(predicted)
        noise = rng.standard_normal((count, 6))
        is_prior = rng.random(count) < self.prior_share
        family = np.arange(count) // self.family_size
        means, root = predicted.copy(), np.empty((count, 6, 6))
        for iteration in range(self.iterations):
            places = means[:: self.family_size]
            gradient, information = observation.linearise(places, iteration)
            if self.family_size > 1:
                means, gradient, information = (a[family] for a in (places, gradient, information))
            gaussian_loops.climb(
                predicted, variances, gradient, information, _STEP_LIMIT, means, root
            )
        warps, log_ratio = np.empty_like(predicted), np.empty(count)
        gaussian_loops.draw(
            predicted, variances, means, root, noise, is_prior, self.prior_share, warps, log_ratio
        )
        return Draw(warps, log_ratio)


Proposal: TypeAlias = PriorProposal | GaussianProposal
"""Draws one new particle from each predicted one."""
