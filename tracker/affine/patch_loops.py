"""Compiled loops over particles and template samples: the cost of a tracker is here.

A patch stays in the processor's first cache from sampling to its sums, so a comparison costs
little more than reading the image. Arrays are float32 and contiguous, `scratch` is (6, m).
Compiled at first use and cached on disk.
"""

import numpy as np
from numba import njit

_REORDER = {"reassoc", "contract", "nsz", "arcp"}  # sums may be vectorised; NaN stays NaN
_MIN_VARIANCE = np.float32(1.0)
_MIN_TEMPLATE_VARIANCE = np.float32(1e-2)
_RIM = np.float32(1e-2)
"""Pixels: corners farther inside leave no doubt about the points between them."""
_ZERO, _ONE, _HALF = np.float32(0.0), np.float32(1.0), np.float32(0.5)


@njit(cache=True, fastmath=_REORDER, error_model="numpy")
def sample(
    grey: np.ndarray,
    mask: np.ndarray,
    warp: np.ndarray,
    points: np.ndarray,
    patch: np.ndarray,
    weights: np.ndarray,
    places: np.ndarray,
) -> np.float32:
    """Fills `patch` (m,) and `weights` (m,), 1 where the sample is visible; returns their sum.

    Bilinear. Invisible is what lies outside `grey` (h, w) or touches a zero of `mask` (h, w); a
    mask without elements hides nothing. `places` (3, m) is scratch: index and fractions. The first
    and the last of `points` (2, m) are opposite corners of the rectangle that holds all.
    """
    height, width = grey.shape
    image, count = grey.reshape(-1), points.shape[1]
    index, fx, fy = places[0].view(np.int32), places[1], places[2]
    a, b, x0 = np.float32(warp[0, 0]), np.float32(warp[0, 1]), np.float32(warp[0, 2])
    c, d, y0 = np.float32(warp[1, 0]), np.float32(warp[1, 1]), np.float32(warp[1, 2])
    right, bottom = np.float32(width - 1), np.float32(height - 1)
    row, last_x, last_y = np.int32(width), np.int32(width - 2), np.int32(height - 2)
    is_whole = _is_inside(points, warp, right, bottom)
    if is_whole:
        for m in range(count):
            x = a * points[0, m] + b * points[1, m] + x0
            y = c * points[0, m] + d * points[1, m] + y0
            weights[m] = _ONE
            ix, iy = min(np.int32(x), last_x), min(np.int32(y), last_y)
            fx[m], fy[m] = x - np.float32(ix), y - np.float32(iy)
            index[m] = iy * row + ix
    else:
        for m in range(count):
            x = a * points[0, m] + b * points[1, m] + x0
            y = c * points[0, m] + d * points[1, m] + y0
            is_inside = (x >= _ZERO) & (x <= right) & (y >= _ZERO) & (y <= bottom)
            weights[m] = _ONE if is_inside else _ZERO
            x, y = (x, y) if is_inside else (_ZERO, _ZERO)
            ix, iy = min(np.int32(x), last_x), min(np.int32(y), last_y)
            fx[m], fy[m] = x - np.float32(ix), y - np.float32(iy)
            index[m] = iy * row + ix
    one, below = np.uint32(1), np.uint32(width)
    for m in range(count):
        k = np.uint32(index[m])  # unsigned: no test for negative indices
        k1, k2 = np.uint32(k + one), np.uint32(k + below)
        top = image[k] + fx[m] * (image[k1] - image[k])
        low = image[k2] + fx[m] * (image[np.uint32(k2 + one)] - image[k2])
        patch[m] = top + fy[m] * (low - top)
    if mask.size:
        hidden = mask.reshape(-1)
        for m in range(count):
            k = np.uint32(index[m])
            k1, k2 = np.uint32(k + one), np.uint32(k + below)
            is_seen = hidden[k] & hidden[k1] & hidden[k2] & hidden[np.uint32(k2 + one)]
            weights[m] *= np.float32(is_seen)
    elif is_whole:
        return np.float32(count)
    total = _ZERO
    for m in range(count):
        total += weights[m]
    return total


@njit(cache=True, error_model="numpy")
def _is_inside(points: np.ndarray, warp: np.ndarray, right: np.float32, bottom: np.float32) -> bool:
    """Whether the rectangle between first and last point lies in the image, and not on its rim."""
    for u in (points[0, 0], points[0, -1]):
        for v in (points[1, 0], points[1, -1]):
            x = warp[0, 0] * u + warp[0, 1] * v + warp[0, 2]
            y = warp[1, 0] * u + warp[1, 1] * v + warp[1, 2]
            if not (_RIM < x < right - _RIM and _RIM < y < bottom - _RIM):
                return False
    return True


@njit(cache=True, fastmath=_REORDER, error_model="numpy")
def mean_and_deviation(
    values: np.ndarray, weights: np.ndarray, total: np.float32, floor: np.float32
) -> tuple[np.float32, np.float32]:
    """Weighted mean of `values` (m,), and the root of their variance or of `floor`."""
    mean = _ZERO
    for m in range(len(values)):
        mean += weights[m] * values[m]
    mean /= total
    variance = _ZERO
    for m in range(len(values)):
        difference = values[m] - mean
        variance += weights[m] * difference * difference
    return mean, np.sqrt(max(variance / total, floor))


@njit(cache=True, fastmath=_REORDER, error_model="numpy")
def normalise(
    values: np.ndarray, weights: np.ndarray, total: np.float32, floor: np.float32, out: np.ndarray
) -> np.float32:
    """`values` (m,) less their mean over their deviation, which is returned; both weighted."""
    mean, deviation = mean_and_deviation(values, weights, total, floor)
    gain = _ONE / deviation
    for m in range(len(values)):
        out[m] = (values[m] - mean) * gain
    return deviation


@njit(cache=True, fastmath=_REORDER, error_model="numpy")
def remove_subspace(
    residual: np.ndarray, weights: np.ndarray, total: np.float32, basis: np.ndarray
) -> None:
    """Takes from `residual` (m,) its part in the span of the orthonormal rows of `basis` (k, m)."""
    for k in range(len(basis)):
        part = _ZERO
        for m in range(len(residual)):
            part += weights[m] * residual[m] * basis[k, m]
        part *= np.float32(len(residual)) / total
        for m in range(len(residual)):
            residual[m] -= part * basis[k, m]


@njit(cache=True, fastmath=_REORDER, error_model="numpy")
def _residual(
    grey: np.ndarray,
    mask: np.ndarray,
    warp: np.ndarray,
    points: np.ndarray,
    values: np.ndarray,
    basis: np.ndarray,
    scratch: np.ndarray,
) -> tuple[np.float32, np.float32, np.ndarray]:
    """Residual into scratch[3], weights into scratch[5].

    Returns the number of visible samples, and over them the deviation of the template and the
    template (m,) normalised. `values` (m,) are normalised over all samples.
    """
    residual, template, weights = scratch[3], scratch[4], scratch[5]
    deviation = _ONE
    total = sample(grey, mask, warp, points, residual, weights, scratch[:3])
    if total < _ONE:
        return _ZERO, deviation, template
    if total == len(values):
        template = values
    else:
        deviation = normalise(values, weights, total, _MIN_TEMPLATE_VARIANCE, template)
    mean, spread = mean_and_deviation(residual, weights, total, _MIN_VARIANCE)
    gain = _ONE / spread
    for m in range(len(values)):
        residual[m] = template[m] - (residual[m] - mean) * gain
    if len(basis):
        remove_subspace(residual, weights, total, basis)
    return total, deviation, template


@njit(cache=True, fastmath=_REORDER, error_model="numpy")
def compare(
    grey: np.ndarray,
    mask: np.ndarray,
    warps: np.ndarray,
    points: np.ndarray,
    values: np.ndarray,
    basis: np.ndarray,
    limit: float,
    scratch: np.ndarray,
    out: np.ndarray,
) -> None:
    """Into `out` (n, 3): correlation, visible fraction and mean Huber cost."""
    residual, weights = scratch[3], scratch[5]
    clip = np.float32(limit)
    for i in range(len(warps)):
        total, _, template = _residual(grey, mask, warps[i], points, values, basis, scratch)
        correlation, cost = _ZERO, _ZERO
        for m in range(len(values)):
            r = residual[m]
            excess = abs(r) - clip
            excess = excess if excess > _ZERO else _ZERO
            correlation += weights[m] * template[m] * (template[m] - r)
            cost += weights[m] * (r * r - excess * excess)
        visible = max(total, _ONE)
        out[i, 0], out[i, 1], out[i, 2] = (
            correlation / visible,
            total / len(values),
            _HALF * cost / visible,
        )


@njit(cache=True, fastmath=_REORDER, error_model="numpy")
def linearise(
    grey: np.ndarray,
    mask: np.ndarray,
    warps: np.ndarray,
    points: np.ndarray,
    values: np.ndarray,
    basis: np.ndarray,
    jacobian: np.ndarray,
    whole_information: np.ndarray,
    limit: float,
    scratch: np.ndarray,
    gradient: np.ndarray,
    information: np.ndarray,
    fit: np.ndarray,
) -> None:
    """Mean of J^T r (n, 6) and of J^T J (n, 6, 6) over the visible samples.

    Into `fit` (n, 2): visible fraction and mean squared residual.
    `jacobian` (6, m) is that of the template normalised over all samples, so that its rows have
    no part along 1 and the template; `whole_information` (6, 6) holds if all is visible.
    """
    residual, weights = scratch[3], scratch[5]
    count, clip = len(values), np.float32(limit)
    for i in range(len(warps)):
        total, deviation, template = _residual(grey, mask, warps[i], points, values, basis, scratch)
        fit[i, 0], fit[i, 1] = total / count, _ZERO
        if total < _ONE:
            gradient[i], information[i] = 0.0, 0.0
            continue
        total_r, total_rT, squared = _ZERO, _ZERO, _ZERO
        for m in range(count):
            r = residual[m]
            squared += weights[m] * r * r
            r = r if r < clip else clip
            r = weights[m] * (r if r > -clip else -clip)
            residual[m] = r
            total_r += r
            total_rT += r * template[m]
        fit[i, 1] = squared / total
        if total == count:
            information[i] = whole_information
        else:  # mean and deviation over the visible samples move with the warp
            for m in range(count):
                residual[m] -= weights[m] * (total_r + total_rT * template[m]) / total
            normal_matrix(jacobian, template, weights, total, deviation, information[i])
        for j in range(6):
            product = _ZERO
            for m in range(count):
                product += residual[m] * jacobian[j, m]
            gradient[i, j] = product / (total * deviation)


@njit(cache=True, fastmath=_REORDER, error_model="numpy")
def normal_matrix(
    jacobian: np.ndarray,
    template: np.ndarray,
    weights: np.ndarray,
    total: np.float32,
    deviation: np.float32,
    out: np.ndarray,
) -> None:
    """Mean of J^T J (6, 6) of the normalised template over the visible samples."""
    count = len(weights)
    mean, along = np.zeros(6, np.float32), np.zeros(6, np.float32)
    for j in range(6):
        for m in range(count):
            mean[j] += weights[m] * jacobian[j, m]
            along[j] += weights[m] * template[m] * jacobian[j, m]
    for j in range(6):
        for k in range(j + 1):
            product = _ZERO
            for m in range(count):
                product += weights[m] * jacobian[j, m] * jacobian[k, m]
            value = product / total - (mean[j] * mean[k] + along[j] * along[k]) / (total * total)
            out[j, k] = out[k, j] = value / (deviation * deviation)
