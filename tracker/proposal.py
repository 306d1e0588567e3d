"""Where new particles are drawn: the transition prior, or the Gaussian importance function.

Both return warps with `log p(X_k | X_{k-1}) - log q(X_k | X_{k-1}, y_k)`, the part of the weight of
[IGPF2021] Eq (11) that the likelihood does not give.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tracker import cholesky_loops
from tracker.likelihood import Observation
from tracker.state_space import StateSpace

_STEP_LIMIT = 0.5


@dataclass(frozen=True, eq=False)
class Draw:
    """New particles and the log ratio of prior to proposal density."""

    warps: np.ndarray
    """(n, 3, 3)"""
    log_ratio: np.ndarray
    """(n,)"""


class Proposal(Protocol):
    """Draws one new particle from each predicted one."""

    def draw(
        self,
        predicted: np.ndarray,
        variances: np.ndarray,
        observation: Observation,
        space: StateSpace,
        rng: np.random.Generator,
    ) -> Draw:
        """Draws around `predicted` (n, 3, 3), whose process noise has `variances` (6,)."""
        ...


@dataclass(frozen=True)
class PriorProposal:
    """The transition density itself: the image is not consulted (CONDENSATION)."""

    def draw(
        self,
        predicted: np.ndarray,
        variances: np.ndarray,
        observation: Observation,
        space: StateSpace,
        rng: np.random.Generator,
    ) -> Draw:
        """Perturbs each predicted warp by process noise; the ratio is one."""
        del observation
        e = rng.standard_normal((len(predicted), 6)) * np.sqrt(variances)
        return Draw(space.perturb(predicted, e), np.zeros(len(predicted)))


@dataclass(frozen=True)
class GaussianProposal:
    """Gaussian importance function on the state space, linearised at the image.

    The moments of [IGPF2021] Eqs (20)-(23) in information form, `Sigma = (Q^-1 + J^T R^-1 J)^-1`,
    iterated as in [Kwon2014]. A share of the particles may come from the prior (defensive
    mixture); all are then weighted by the mixture density, with the det Jr terms that densities
    on a non-unimodular group need.
    """

    iterations: int = 2
    """Linearisations per image (Gauss-Newton steps)."""
    prior_share: float = 0.1
    """Share of particles drawn from the transition prior, from 0 to below 1."""

    def __post_init__(self) -> None:
        if self.iterations < 1:
            raise ValueError(f"iterations must be 1 or greater, got {self.iterations}")
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
        """Draws from the local posterior of each predicted warp."""
        count = len(predicted)
        noise = rng.standard_normal((count, 6))
        is_defensive = rng.random(count) < self.prior_share
        means, root = self._local_posterior(predicted, variances, observation, space)
        e = np.empty_like(noise)
        cholesky_loops.solve_upper(root, noise, e)
        warps = space.perturb(means, e)
        spread = noise[is_defensive] * np.sqrt(variances)
        warps[is_defensive] = space.perturb(predicted[is_defensive], spread)
        if self.prior_share > 0.0:
            e = space.difference(means, warps)
        log_q = _log_density(e, root, space)
        from_prior = space.difference(predicted, warps)
        prior_root = np.diag(1.0 / np.sqrt(variances))
        log_p = _log_density(from_prior, prior_root, space)
        if self.prior_share > 0.0:
            share = self.prior_share
            log_q = np.logaddexp(np.log1p(-share) + log_q, np.log(share) + log_p)
        return Draw(warps, log_p - log_q)

    def _local_posterior(
        self,
        predicted: np.ndarray,
        variances: np.ndarray,
        observation: Observation,
        space: StateSpace,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Means (n, 3, 3), lower Cholesky factors of the precisions (n, 6, 6).

        [IGPF2021] Eqs (21)-(23).
        """
        means, e = predicted, np.zeros((len(predicted), 6))
        root = np.empty((len(predicted), 6, 6))
        for step in range(self.iterations):
            gradient, precision = observation.linearise(means)
            precision[:, range(6), range(6)] += 1.0 / variances
            cholesky_loops.factorise(precision, root)
            delta = gradient - e / variances
            cholesky_loops.solve_lower(root, delta, delta)
            cholesky_loops.solve_upper(root, delta, delta)
            means = space.perturb(means, _bounded(delta))
            if step + 1 < self.iterations:
                e = space.difference(predicted, means)
        return means, root


def _bounded(delta: np.ndarray) -> np.ndarray:
    """Steps shortened to the basin where a linearisation means anything; NaN becomes 0."""
    delta = np.nan_to_num(delta, nan=0.0, posinf=0.0, neginf=0.0)
    length = np.linalg.norm(delta, axis=-1, keepdims=True)
    return delta * np.minimum(1.0, _STEP_LIMIT / np.maximum(length, 1e-12))


def _log_density(e: np.ndarray, root: np.ndarray, space: StateSpace) -> np.ndarray:
    """(n,) log Gaussian density at e, less (2 pi)^3, against the invariant measure.

    `root` (..., 6, 6) is the lower Cholesky factor of the precision.
    """
    whitened = (np.swapaxes(root, -1, -2) @ e[..., None])[..., 0]
    log_det = np.log(np.diagonal(root, axis1=-2, axis2=-1)).sum(axis=-1)
    return log_det - 0.5 * (whitened**2).sum(axis=-1) - space.log_volume(e)
