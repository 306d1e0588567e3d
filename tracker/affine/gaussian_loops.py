"""Compiled loops over particles, each with its own Gaussian on Aff(2).

A 6 x 6 system a particle: NumPy's and LAPACK's overhead would exceed the arithmetic tenfold.
Compiled at first use and cached on disk.
"""

import math

import numpy as np
from numba import njit

from tracker.affine.aff2_loops import difference_one, log_det_right_jacobian, perturb_one


@njit(cache=True, error_model="numpy")
def climb(
    predicted: np.ndarray,
    variances: np.ndarray,
    gradient: np.ndarray,
    information: np.ndarray,
    limit: float,
    means: np.ndarray,
    root: np.ndarray,
) -> None:
    """One Gauss-Newton step of each mean (n, 3, 3) to the maximum of prior times likelihood.

    The prior is N(predicted, diag(variances)), the likelihood has `gradient` (n, 6) and
    `information` (n, 6, 6) at the means. Steps are cut to the length `limit`; where the system has
    no solution there is none. Fills `root` (n, 6, 6), the lower Cholesky factor of the precision.
    """
    e, step = np.empty(6), np.empty(6)
    for i in range(len(means)):
        difference_one(predicted[i], means[i], e)
        for j in range(6):
            information[i, j, j] += 1.0 / variances[j]
            step[j] = gradient[i, j] - e[j] / variances[j]
        factorise(information[i], root[i])
        solve_lower(root[i], step, step)
        solve_upper(root[i], step, step)
        length = 0.0
        for j in range(6):
            length += step[j] * step[j]
        length = math.sqrt(length)
        if length < math.inf:
            if length > limit:
                for j in range(6):
                    step[j] *= limit / length
            perturb_one(means[i], step, means[i])


@njit(cache=True, error_model="numpy")
def draw(
    predicted: np.ndarray,
    variances: np.ndarray,
    means: np.ndarray,
    root: np.ndarray,
    noise: np.ndarray,
    is_prior: np.ndarray,
    prior_share: float,
    warps: np.ndarray,
    log_ratio: np.ndarray,
) -> None:
    """A warp (n, 3, 3) from each Gaussian, or from the prior where `is_prior` (n,) says so.

    `noise` (n, 6) is standard normal. Fills `log_ratio` (n,): log p - log q, p the prior and q the
    mixture of both, each against the invariant measure.
    """
    e, from_prior = np.empty(6), np.empty(6)
    prior_log_det = 0.0
    for j in range(6):
        prior_log_det -= 0.5 * math.log(variances[j])
    for i in range(len(predicted)):
        if is_prior[i]:
            for j in range(6):
                from_prior[j] = noise[i, j] * math.sqrt(variances[j])
            perturb_one(predicted[i], from_prior, warps[i])
            difference_one(means[i], warps[i], e)
        else:
            solve_upper(root[i], noise[i], e)
            perturb_one(means[i], e, warps[i])
            difference_one(predicted[i], warps[i], from_prior)
        log_p = prior_log_det - log_det_right_jacobian(from_prior)
        log_q = -log_det_right_jacobian(e)
        for j in range(6):
            log_p -= 0.5 * from_prior[j] * from_prior[j] / variances[j]
            whitened = 0.0
            for k in range(j, 6):
                whitened += root[i, k, j] * e[k]
            log_q += math.log(root[i, j, j]) - 0.5 * whitened * whitened
        if prior_share > 0.0:
            a, b = math.log1p(-prior_share) + log_q, math.log(prior_share) + log_p
            log_q = max(a, b) + math.log1p(math.exp(-abs(a - b)))
        log_ratio[i] = log_p - log_q


@njit(cache=True, error_model="numpy")
def factorise(A: np.ndarray, out: np.ndarray) -> None:
    """Lower Cholesky factor of a positive definite A (d, d); NaN where A is not."""
    for row in range(len(A)):
        for column in range(row + 1):
            rest = A[row, column]
            for k in range(column):
                rest -= out[row, k] * out[column, k]
            if row > column:
                out[row, column] = rest / out[column, column]
            else:
                out[row, row] = math.sqrt(rest) if rest > 0.0 else math.nan
        for column in range(row + 1, len(A)):
            out[row, column] = 0.0


@njit(cache=True, error_model="numpy")
def solve_lower(root: np.ndarray, b: np.ndarray, out: np.ndarray) -> None:
    """x (d,) of `L x = b`."""
    for row in range(len(b)):
        rest = b[row]
        for k in range(row):
            rest -= root[row, k] * out[k]
        out[row] = rest / root[row, row]


@njit(cache=True, error_model="numpy")
def solve_upper(root: np.ndarray, b: np.ndarray, out: np.ndarray) -> None:
    """x (d,) of `L^T x = b`."""
    for row in range(len(b) - 1, -1, -1):
        rest = b[row]
        for k in range(row + 1, len(b)):
            rest -= root[k, row] * out[k]
        out[row] = rest / root[row, row]
