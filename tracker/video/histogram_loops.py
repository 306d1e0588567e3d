"""Compiled loops over pixels that make orientation histograms of gradients.

Compiled at first use and cached on disk.
"""

import math

import numpy as np
from numba import njit

_REORDER = {"reassoc", "contract", "nsz", "arcp"}  # rows may be vectorised
_ZERO, _ONE, _TINY = np.float32(0.0), np.float32(1.0), np.float32(1e-12)
_ATAN = np.array(
    [
        0.0028662257,
        -0.0161657367,
        0.0429096138,
        -0.0752896400,
        0.1065626393,
        -0.1420889944,
        0.1999355085,
        -0.3333314528,
        1.0,
    ],
    np.float32,
)
"""Arctangent from 0 to 1 as an odd polynomial, from the highest power [Abramowitz1964] 4.4.49; a
call of atan2 would cost ten times as much as all the rest."""


@njit(cache=True, error_model="numpy")
def orientation_histograms(grey: np.ndarray, cell_px: int, out: np.ndarray) -> None:
    """Mean gradient of each cell by orientation into `out` (bins, rows, columns), as [HOG2005].

    A gradient counts for the two bins next to its orientation, which has no sign. Central
    differences of `grey` (h, w) float32, none at its rim; `rows * cell_px` is at most h.
    """
    height, width = grey.shape
    bins, rows, columns = out.shape
    last_x = min(width - 1, columns * cell_px)
    place, size = np.zeros(width, np.float32), np.zeros(width, np.float32)
    out[:] = 0.0
    for y in range(1, min(height - 1, rows * cell_px)):
        _row_gradients(grey, y, last_x, bins, place, size)
        for x in range(1, last_x):
            low = int(place[x])
            share = place[x] - np.float32(low)
            first = low if low < bins else 0
            second = first + 1 if first + 1 < bins else 0
            row, column = y // cell_px, x // cell_px
            out[first, row, column] += (_ONE - share) * size[x]
            out[second, row, column] += share * size[x]
    out /= np.float32(cell_px * cell_px)


@njit(cache=True, fastmath=_REORDER, error_model="numpy")
def _row_gradients(
    grey: np.ndarray, y: int, last_x: int, bins: int, place: np.ndarray, size: np.ndarray
) -> None:
    """Orientation [bins, 0 to `bins`] and length of the gradients of a row up to `last_x`."""
    to_bins, whole = np.float32(bins / math.pi), np.float32(bins)
    half = np.float32(0.5 * bins)
    for x in range(1, last_x):
        dx, dy = grey[y, x + 1] - grey[y, x - 1], grey[y + 1, x] - grey[y - 1, x]
        ax, ay = abs(dx), abs(dy)
        z = min(ax, ay) / max(max(ax, ay), _TINY)
        zz = z * z
        series = _ATAN[0]
        for k in range(1, len(_ATAN)):
            series = series * zz + _ATAN[k]
        angle = to_bins * z * series
        angle = half - angle if ay > ax else angle
        place[x] = whole - angle if dx * dy < _ZERO else angle
        size[x] = math.sqrt(dx * dx + dy * dy)
