"""Compiled functions behind `tracker.affine.aff2`: closed forms without temporaries.

With hundreds of particles a stack of NumPy calls costs ten times the arithmetic; these cost the
arithmetic. Generalised ufuncs broadcast over leading axes; Numba wants the shape of a result among
the arguments, so some have one, `like`, of which only the shape counts. All compile at the first
import and are cached on disk.
"""

import math

import numba
import numpy as np
from numba import njit

_TAYLOR_TERMS = 13
_SERIES_BELOW = 1e-6


@njit(cache=True, error_model="numpy")
def difference_one(X: np.ndarray, Y: np.ndarray, out: np.ndarray) -> None:
    """Tangent vector (6,) from X to Y (3, 3)."""
    det = X[0, 0] * X[1, 1] - X[0, 1] * X[1, 0]
    a, b, c, d = X[1, 1] / det, -X[0, 1] / det, -X[1, 0] / det, X[0, 0] / det
    x, y = Y[0, 2] - X[0, 2], Y[1, 2] - X[1, 2]
    _log_into(
        a * Y[0, 0] + b * Y[1, 0],
        a * Y[0, 1] + b * Y[1, 1],
        c * Y[0, 0] + d * Y[1, 0],
        c * Y[0, 1] + d * Y[1, 1],
        a * x + b * y,
        c * x + d * y,
        out,
    )


@njit(cache=True, error_model="numpy")
def perturb_one(X: np.ndarray, e: np.ndarray, out: np.ndarray) -> None:
    """X exp(hat(e)) (3, 3) of X (3, 3) and e (6,)."""
    V, E = _integral_and_exponential(e[0], e[1], e[2], e[3])
    x, y = V[0] * e[4] + V[1] * e[5], V[2] * e[4] + V[3] * e[5]
    for row in range(2):
        a, b = X[row, 0], X[row, 1]
        out[row, 0] = a * E[0] + b * E[2]
        out[row, 1] = a * E[1] + b * E[3]
        out[row, 2] = a * x + b * y + X[row, 2]
    out[2, 0], out[2, 1], out[2, 2] = 0.0, 0.0, 1.0


@njit(cache=True, error_model="numpy")
def log_det_right_jacobian(e: np.ndarray) -> float:
    """ln |det Jr(e)| at a tangent vector (6,), from the eigenvalues of `ad`.

    On the 2x2 part `ad` has eigenvalues 0, 0, +-2 sqrt(D); on the translations those of the 2x2
    block, tau +- sqrt(D). Densities on this non-unimodular group need it: both the prior and the
    proposal must be taken against the same measure.
    """
    _, s = _cosine_sine(e[1] ** 2 + e[3] ** 2 - e[2] ** 2)
    V, _ = _integral_and_exponential(-e[0], -e[1], -e[2], -e[3])
    det = V[0] * V[3] - V[1] * V[2]
    return 2.0 * math.log(abs(s)) + math.log(abs(det))


@njit(cache=True, error_model="numpy")
def mean(X: np.ndarray, weights: np.ndarray, iterations: int, out: np.ndarray) -> None:
    """Intrinsic mean (3, 3) of X (n, 3, 3) under `weights` (n,).

    Elements without a logarithm at the mean so far count as if they were there.
    """
    e, shift = np.empty(6), np.empty(6)
    out[:] = X[np.argmax(weights)]
    for _ in range(iterations):
        shift[:] = 0.0
        for i in range(len(X)):
            difference_one(out, X[i], e)
            if _is_finite(e):
                for j in range(6):
                    shift[j] += weights[i] * e[j]
        perturb_one(out, shift, out)


@njit(cache=True, error_model="numpy")
def covariance(X: np.ndarray, weights: np.ndarray, centre: np.ndarray, out: np.ndarray) -> None:
    """Weighted sum (6, 6) of outer products of the tangent vectors from `centre` to X (n, 3, 3)."""
    e = np.empty(6)
    out[:] = 0.0
    for i in range(len(X)):
        difference_one(centre, X[i], e)
        if _is_finite(e):
            for j in range(6):
                for k in range(j + 1):
                    out[j, k] += weights[i] * e[j] * e[k]
    for j in range(6):
        for k in range(j):
            out[k, j] = out[j, k]


@njit(cache=True, error_model="numpy")
def _integral_and_exponential(
    e1: float, e2: float, e3: float, e4: float
) -> tuple[tuple[float, float, float, float], tuple[float, float, float, float]]:
    """V = int_0^1 exp(s M) ds and exp(M) of the 2x2 block M, row by row.

    Taylor series of M / 2^j, then j doublings: V(2M) = (I + exp M) V(M) / 2.
    """
    a, b, c, d = e1 + e2, e4 - e3, e4 + e3, e1 - e2
    size = max(abs(a) + abs(b), abs(c) + abs(d))
    if not size < 700.0:
        return (math.nan, math.nan, math.nan, math.nan), (math.nan, math.nan, math.nan, math.nan)
    doublings = 0
    while size > 0.5:
        size *= 0.5
        doublings += 1
    shrink = 0.5**doublings
    a, b, c, d = a * shrink, b * shrink, c * shrink, d * shrink
    va, vb, vc, vd = 1.0, 0.0, 0.0, 1.0
    for n in range(_TAYLOR_TERMS, 1, -1):  # Horner: V = I + M/2 (I + M/3 (I + ...))
        va, vb, vc, vd = (
            1.0 + (a * va + b * vc) / n,
            (a * vb + b * vd) / n,
            (c * va + d * vc) / n,
            1.0 + (c * vb + d * vd) / n,
        )
    ea, eb = 1.0 + a * va + b * vc, a * vb + b * vd
    ec, ed = c * va + d * vc, 1.0 + c * vb + d * vd
    for _ in range(doublings):
        va, vb, vc, vd = (
            0.5 * (va + ea * va + eb * vc),
            0.5 * (vb + ea * vb + eb * vd),
            0.5 * (vc + ec * va + ed * vc),
            0.5 * (vd + ec * vb + ed * vd),
        )
        ea, eb, ec, ed = (ea * ea + eb * ec, eb * (ea + ed), ec * (ea + ed), ed * ed + eb * ec)
    return (va, vb, vc, vd), (ea, eb, ec, ed)


@njit(cache=True, error_model="numpy")
def _log_into(a: float, b: float, c: float, d: float, x: float, y: float, out: np.ndarray) -> None:
    """Logarithm (6,) of the element [[a, b, x], [c, d, y], [0, 0, 1]]."""
    scale, k, aspect, turn, shear = _block_logarithm(a, b, c, d)
    e1, e2, e3, e4 = scale, k * aspect, k * turn, k * shear
    out[0], out[1], out[2], out[3], out[4], out[5] = e1, e2, e3, e4, math.nan, math.nan
    if math.isfinite(e1 + e2 + e3 + e4):
        V, _ = _integral_and_exponential(e1, e2, e3, e4)
        det = V[0] * V[3] - V[1] * V[2]
        out[4] = (V[3] * x - V[1] * y) / det
        out[5] = (V[0] * y - V[2] * x) / det


@njit(cache=True, error_model="numpy")
def _block_logarithm(
    a: float, b: float, c: float, d: float
) -> tuple[float, float, float, float, float]:
    """1/2 ln det, k, and the aspect, rotation and shear parts of A, of which k times is the log.

    `log(A) = 1/2 ln det A I + k (A - tau I)` by Cayley-Hamilton, tau the half trace.
    """
    tau, aspect, turn, shear = 0.5 * (a + d), 0.5 * (a - d), 0.5 * (c - b), 0.5 * (c + b)
    det = a * d - b * c
    if not (0.0 < det < math.inf):
        return math.nan, math.nan, aspect, turn, shear
    D = aspect * aspect + shear * shear - turn * turn
    q = math.sqrt(abs(D))
    if q < _SERIES_BELOW * abs(tau):
        k = 1.0 / tau if tau > 0 else math.nan
    elif D < 0:
        k = math.atan2(q, tau) / q
    else:
        k = 0.5 * math.log((tau + q) / (tau - q)) / q if tau > q else math.nan
    return 0.5 * math.log(det), k, aspect, turn, shear


@njit(cache=True, error_model="numpy")
def _is_finite(e: np.ndarray) -> bool:
    for j in range(len(e)):
        if not math.isfinite(e[j]):
            return False
    return True


@njit(cache=True, error_model="numpy")
def _cosine_sine(D: float) -> tuple[float, float]:
    """cosh(q) and sinh(q) / q with q = sqrt(D); trigonometric for D < 0, smooth at 0."""
    q = math.sqrt(abs(D))
    if q < 1e-4:
        return 1.0 + 0.5 * D, 1.0 + D / 6.0
    if D > 0:
        return math.cosh(q), math.sinh(q) / q
    return math.cos(q), math.sin(q) / q


@numba.guvectorize("(f8[:,:], f8[:,:], f8[:], f8[:])", "(i,i),(i,i),(k)->(k)", cache=True)
def difference(X: np.ndarray, Y: np.ndarray, like: np.ndarray, out: np.ndarray) -> None:
    """Tangent vector (6,) from X to Y (3, 3)."""
    difference_one(X, Y, out)


@numba.guvectorize("(f8[:,:], f8[:], f8[:,:])", "(i,i),(k)->(i,i)", cache=True)
def perturb(X: np.ndarray, e: np.ndarray, out: np.ndarray) -> None:
    """X exp(hat(e)) (3, 3) of X (3, 3) and e (6,)."""
    perturb_one(X, e, out)


@numba.guvectorize("(f8[:,:], f8[:,:], f8, f8[:,:])", "(i,i),(i,i),()->(i,i)", cache=True)
def advance(X: np.ndarray, Y: np.ndarray, share: float, out: np.ndarray) -> None:
    """Y (3, 3) moved on by a share of the tangent vector from X to Y."""
    e = np.empty(6)
    difference_one(X, Y, e)
    for j in range(6):
        e[j] *= share
    perturb_one(Y, e, out)


@numba.guvectorize("(f8[:,:], f8, f8, b1[:])", "(i,i),(),()->()", cache=True)
def is_valid(X: np.ndarray, low: float, high: float, out: np.ndarray) -> None:
    """True where X (3, 3) is finite and det A from `low` to `high`."""
    det = X[0, 0] * X[1, 1] - X[0, 1] * X[1, 0]
    total = 0.0
    for row in range(2):
        for column in range(3):
            total += abs(X[row, column])
    out[0] = (low <= det <= high) and total < math.inf


@numba.guvectorize("(f8[:,:], f8[:], f8[:])", "(i,i),(k)->(k)", cache=True)
def polar(X: np.ndarray, like: np.ndarray, out: np.ndarray) -> None:
    """Affine parameters (6,) of an element (3, 3)."""
    a, b, c, d = X[0, 0], X[0, 1], X[1, 0], X[1, 1]
    _, k, aspect, _, shear = _block_logarithm(
        a * a + c * c, a * b + c * d, a * b + c * d, b * b + d * d
    )
    det = a * d - b * c
    out[0] = 0.5 * math.log(det) if det > 0 else math.nan
    out[1] = 0.5 * k * aspect
    out[2] = math.atan2(c - b, a + d)
    out[3] = 0.5 * k * shear
    out[4], out[5] = X[0, 2], X[1, 2]


@numba.guvectorize("(f8[:], f8[:,:], f8[:,:])", "(k),(i,i)->(i,i)", cache=True)
def from_polar(p: np.ndarray, like: np.ndarray, out: np.ndarray) -> None:
    """Element (3, 3) of affine parameters (6,)."""
    c, s = _cosine_sine(p[1] ** 2 + p[3] ** 2)
    growth = math.exp(p[0])
    a, b = growth * (c + s * p[1]), growth * s * p[3]
    d = growth * (c - s * p[1])
    cos, sin = math.cos(p[2]), math.sin(p[2])
    out[0, 0], out[0, 1] = cos * a - sin * b, cos * b - sin * d
    out[1, 0], out[1, 1] = sin * a + cos * b, sin * b + cos * d
    out[0, 2], out[1, 2] = p[4], p[5]
    out[2, 0], out[2, 1], out[2, 2] = 0.0, 0.0, 1.0
