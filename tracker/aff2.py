"""The affine group Aff(2) of the plane, on stacked arrays.

An element is a (..., 3, 3) matrix `[[A, t], [0, 0, 1]]` with det A > 0, in float64. Its tangent
vector `(..., 6)` lists scale, aspect, rotation, shear, x, y, in the order of [IGPF2021] Eq (5).
Perturbations act on the right: `X exp(hat(e))`, so `e` lives in template coordinates. Every
function broadcasts over leading axes. Closed forms replace the general matrix exponential and
logarithm; both are smooth through the identity. Elements without a principal logarithm give NaN,
so check `is_valid` before `log` where particles may have strayed.
"""

from __future__ import annotations

import numpy as np

_NODES, _NODE_WEIGHTS = np.polynomial.legendre.leggauss(8)
_NODES, _NODE_WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _NODE_WEIGHTS
_SERIES_BELOW = 1e-6


def hat(e: np.ndarray) -> np.ndarray:
    """(..., 3, 3) algebra matrix of tangent vectors (..., 6). [IGPF2021] Eq (5)."""
    e = np.asarray(e, float)
    M = np.zeros((*e.shape[:-1], 3, 3))
    M[..., 0, 0] = e[..., 0] + e[..., 1]
    M[..., 0, 1] = e[..., 3] - e[..., 2]
    M[..., 1, 0] = e[..., 3] + e[..., 2]
    M[..., 1, 1] = e[..., 0] - e[..., 1]
    M[..., :2, 2] = e[..., 4:]
    return M


def vee(M: np.ndarray) -> np.ndarray:
    """(..., 6) tangent vectors of algebra matrices (..., 3, 3); inverse of `hat`."""
    e = np.empty((*M.shape[:-2], 6))
    e[..., 0] = 0.5 * (M[..., 0, 0] + M[..., 1, 1])
    e[..., 1] = 0.5 * (M[..., 0, 0] - M[..., 1, 1])
    e[..., 2] = 0.5 * (M[..., 1, 0] - M[..., 0, 1])
    e[..., 3] = 0.5 * (M[..., 1, 0] + M[..., 0, 1])
    e[..., 4:] = M[..., :2, 2]
    return e


def is_valid(X: np.ndarray, det_range: tuple[float, float] = (1e-9, 1e9)) -> np.ndarray:
    """(...,) True where X is finite and det A lies inside `det_range`."""
    with np.errstate(invalid="ignore", over="ignore"):
        det = _det2(X)
        return np.isfinite(X).all(axis=(-2, -1)) & (det >= det_range[0]) & (det <= det_range[1])


def compose(X: np.ndarray, Y: np.ndarray) -> np.ndarray:
    """(..., 3, 3) product X Y: the warp that applies Y first."""
    return X @ Y


def inverse(X: np.ndarray) -> np.ndarray:
    """(..., 3, 3) group inverse."""
    Y = np.zeros_like(X, dtype=float)
    det = _det2(X)
    Y[..., 0, 0] = X[..., 1, 1] / det
    Y[..., 1, 1] = X[..., 0, 0] / det
    Y[..., 0, 1] = -X[..., 0, 1] / det
    Y[..., 1, 0] = -X[..., 1, 0] / det
    Y[..., :2, 2] = -np.einsum("...ij,...j->...i", Y[..., :2, :2], X[..., :2, 2])
    Y[..., 2, 2] = 1.0
    return Y


def exp(e: np.ndarray) -> np.ndarray:
    """(..., 3, 3) group elements of tangent vectors (..., 6).

    Closed form by Cayley-Hamilton on the 2x2 block: with `tau` its half trace and `D` the
    discriminant e2^2 + e4^2 - e3^2, `exp(M) = exp(tau) (c I + s (M - tau I))`.
    """
    e = np.asarray(e, float)
    D = _discriminant(e)
    c, s = _cosine_sine(D)
    growth = np.exp(e[..., 0])
    X = _block(growth * c, growth * s, e)
    V = _left_integral(e, D)
    X[..., :2, 2] = np.einsum("...ij,...j->...i", V, e[..., 4:])
    X[..., 2, 2] = 1.0
    return X


def log(X: np.ndarray) -> np.ndarray:
    """(..., 6) principal logarithm of group elements; NaN where there is none."""
    X = np.asarray(X, float)
    e = np.empty((*X.shape[:-2], 6))
    a = vee(X)
    tau = a[..., 0]
    D = _discriminant(a)
    with np.errstate(invalid="ignore", divide="ignore"):
        e[..., 0] = 0.5 * np.log(_det2(X))
        k = _log_slope(tau, D)
        e[..., 1:4] = k[..., None] * a[..., 1:4]
        V = _left_integral(e, _discriminant(e))
        det = V[..., 0, 0] * V[..., 1, 1] - V[..., 0, 1] * V[..., 1, 0]
        x, y = X[..., 0, 2], X[..., 1, 2]
        e[..., 4] = (V[..., 1, 1] * x - V[..., 0, 1] * y) / det
        e[..., 5] = (V[..., 0, 0] * y - V[..., 1, 0] * x) / det
    return e


def difference(X: np.ndarray, Y: np.ndarray) -> np.ndarray:
    """(..., 6) tangent vector `vee log(X^-1 Y)` that leads from X to Y."""
    return log(inverse(X) @ Y)


def perturb(X: np.ndarray, e: np.ndarray) -> np.ndarray:
    """(..., 3, 3) right perturbation `X exp(hat(e))`. [IGPF2021] Eq (18)."""
    return X @ exp(e)


def adjoint(X: np.ndarray) -> np.ndarray:
    """(..., 6, 6) matrix with `X exp(hat(e)) X^-1 = exp(hat(Ad e))`."""
    basis = hat(np.eye(6))
    M = X[..., None, :, :] @ basis @ inverse(X)[..., None, :, :]
    return np.swapaxes(vee(M), -1, -2)


def algebra_adjoint(e: np.ndarray) -> np.ndarray:
    """(..., 6, 6) matrix of the bracket: `ad(e) f = vee([hat(e), hat(f)])`."""
    basis = hat(np.eye(6))
    M = hat(e)[..., None, :, :]
    return np.swapaxes(vee(M @ basis - basis @ M), -1, -2)


def right_jacobian(e: np.ndarray, terms: int = 24) -> np.ndarray:
    """(..., 6, 6) Jr with `exp(e + d) = exp(e) exp(Jr d)` to first order in d.

    Series `sum_n (-ad e)^n / (n + 1)!`, exact to float64 for |e| up to about 3.
    """
    ad = -algebra_adjoint(e)
    J = np.broadcast_to(np.eye(6), ad.shape).copy()
    term = J.copy()
    for n in range(1, terms):
        term = term @ ad / (n + 1)
        J += term
    return J


def log_det_right_jacobian(e: np.ndarray) -> np.ndarray:
    """(...,) ln |det Jr(e)| from the eigenvalues of `ad`, without a 6x6 matrix.

    On the 2x2 part `ad` has eigenvalues 0, 0, +-2 sqrt(D); on the translations those of the 2x2
    block, tau +- sqrt(D). Densities on this non-unimodular group need it: both the prior and the
    proposal must be taken against the same measure.
    """
    e = np.asarray(e, float)
    D = _discriminant(e)
    _, s = _cosine_sine(D)
    translations = _left_integral(-e, D)
    det = _det2(translations)
    return 2.0 * np.log(np.abs(s)) + np.log(np.abs(det))


def mean(X: np.ndarray, weights: np.ndarray, iterations: int = 3) -> np.ndarray:
    """(3, 3) intrinsic mean of elements (n, 3, 3) under weights (n,) that sum to one.

    Starts at the heaviest element and repeats `Xbar <- Xbar exp(sum w log(Xbar^-1 X))`; a plain
    average of matrices would shrink rotations. [Kwon2010]
    """
    Xbar = X[int(np.argmax(weights))]
    for _ in range(iterations):
        Xbar = perturb(Xbar, weights @ difference(Xbar, X))
    return Xbar


def polar(X: np.ndarray) -> np.ndarray:
    """(..., 6) affine parameters: log scale, aspect, angle [rad], shear, x, y.

    The 2x2 block is split as `R(angle) exp(symmetric)`; x and y are those of the matrix.
    """
    X = np.asarray(X, float)
    A = X[..., :2, :2]
    p = np.empty((*X.shape[:-2], 6))
    gram = vee_block(np.swapaxes(A, -1, -2) @ A)
    with np.errstate(invalid="ignore", divide="ignore"):
        k = 0.5 * _log_slope(gram[..., 0], _discriminant(gram))
        p[..., 0] = 0.5 * np.log(_det2(X))
        p[..., 1] = k * gram[..., 1]
        p[..., 3] = k * gram[..., 3]
    p[..., 2] = np.arctan2(A[..., 1, 0] - A[..., 0, 1], A[..., 0, 0] + A[..., 1, 1])
    p[..., 4:] = X[..., :2, 2]
    return p


def from_polar(p: np.ndarray) -> np.ndarray:
    """(..., 3, 3) warps of affine parameters (..., 6); inverse of `polar`."""
    p = np.asarray(p, float)
    shape = p.copy()
    shape[..., 2] = 0.0
    c, s = _cosine_sine(_discriminant(shape))
    growth = np.exp(p[..., 0])
    S = _block(growth * c, growth * s, shape)
    X = np.zeros_like(S)
    cos, sin = np.cos(p[..., 2]), np.sin(p[..., 2])
    X[..., 0, :2] = cos[..., None] * S[..., 0, :2] - sin[..., None] * S[..., 1, :2]
    X[..., 1, :2] = sin[..., None] * S[..., 0, :2] + cos[..., None] * S[..., 1, :2]
    X[..., :2, 2] = p[..., 4:]
    X[..., 2, 2] = 1.0
    return X


def similarity(scale: float, angle_rad: float, centre: np.ndarray) -> np.ndarray:
    """(3, 3) warp that scales, rotates and then moves the origin to `centre` (2,)."""
    p = np.zeros(6)
    p[0], p[2], p[4:] = np.log(scale), angle_rad, centre
    return from_polar(p)


def vee_block(M: np.ndarray) -> np.ndarray:
    """(..., 4) scale, aspect, rotation, shear coordinates of 2x2 matrices (..., 2, 2)."""
    e = np.empty((*M.shape[:-2], 4))
    e[..., 0] = 0.5 * (M[..., 0, 0] + M[..., 1, 1])
    e[..., 1] = 0.5 * (M[..., 0, 0] - M[..., 1, 1])
    e[..., 2] = 0.5 * (M[..., 1, 0] - M[..., 0, 1])
    e[..., 3] = 0.5 * (M[..., 1, 0] + M[..., 0, 1])
    return e


def _det2(X: np.ndarray) -> np.ndarray:
    return X[..., 0, 0] * X[..., 1, 1] - X[..., 0, 1] * X[..., 1, 0]


def _discriminant(e: np.ndarray) -> np.ndarray:
    """D of the 2x2 block: eigenvalues are e1 +- sqrt(D)."""
    return e[..., 1] ** 2 + e[..., 3] ** 2 - e[..., 2] ** 2


def _cosine_sine(D: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """cosh(q) and sinh(q)/q with q = sqrt(D); trigonometric for D < 0, smooth at 0."""
    q = np.sqrt(np.abs(D))
    is_hyperbolic = D > 0
    q_hyperbolic = np.where(is_hyperbolic, q, 0.0)
    c = np.where(is_hyperbolic, np.cosh(q_hyperbolic), np.cos(q))
    s = np.where(is_hyperbolic, np.sinh(q_hyperbolic), np.sin(q))
    small = q < 1e-4
    return c, np.where(small, 1.0 + D / 6.0, s / np.where(small, 1.0, q))


def _log_slope(tau: np.ndarray, D: np.ndarray) -> np.ndarray:
    """k in `log(A) = 1/2 ln det A I + k (A - tau I)`."""
    q = np.sqrt(np.abs(D))
    small = q < _SERIES_BELOW * np.abs(tau)
    safe = np.where(small, 1.0, q)
    spiral = np.arctan2(q, tau) / safe
    split = np.where(tau > q, 0.5 * np.log((tau + q) / (tau - q)) / safe, np.nan)
    series = np.where(tau > 0, 1.0 / tau, np.nan)
    return np.where(small, series, np.where(D < 0, spiral, split))


def _left_integral(e: np.ndarray, D: np.ndarray) -> np.ndarray:
    """(..., 2, 2) V = int_0^1 exp(s M) ds of the 2x2 block, by 8-point Gauss-Legendre."""
    nodes = _NODES.reshape((-1,) + (1,) * np.ndim(D))
    weights = _NODE_WEIGHTS.reshape(nodes.shape)
    c, s = _cosine_sine(D * nodes**2)
    growth = weights * np.exp(nodes * e[..., 0])
    return _block((growth * c).sum(axis=0), (growth * nodes * s).sum(axis=0), e)[..., :2, :2]


def _block(c: np.ndarray, s: np.ndarray, e: np.ndarray) -> np.ndarray:
    """(..., 3, 3) zeros but for the 2x2 block `c I + s (M - tau I)`."""
    X = np.zeros((*np.shape(c), 3, 3))
    X[..., 0, 0] = c + s * e[..., 1]
    X[..., 0, 1] = s * (e[..., 3] - e[..., 2])
    X[..., 1, 0] = s * (e[..., 3] + e[..., 2])
    X[..., 1, 1] = c - s * e[..., 1]
    return X
