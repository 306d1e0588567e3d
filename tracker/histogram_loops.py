"""Compiled loop over pixels that makes orientation histograms of gradients.

Compiled at first use and cached on disk.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy")
def orientation_histograms(grey: np.ndarray, cell_px: int, out: np.ndarray) -> None:
    """Mean gradient of each cell by orientation into `out` (bins, rows, columns), as [HOG2005].

    A gradient counts for the two bins next to its orientation, which has no sign. Central
    differences of `grey` (h, w) float32, none at its rim; `rows * cell_px` is at most h.
    """
    height, width = grey.shape
    bins, rows, columns = out.shape
    out[:] = 0.0
    per_pixel = 1.0 / (cell_px * cell_px)
    for y in range(1, min(height - 1, rows * cell_px)):
        row = y // cell_px
        for x in range(1, min(width - 1, columns * cell_px)):
            dx = float(grey[y, x + 1] - grey[y, x - 1])
            dy = float(grey[y + 1, x] - grey[y - 1, x])
            place = math.atan2(dy, dx) * (bins / math.pi)
            if place < 0.0:
                place += bins
            low = int(place)
            share = place - low
            size = per_pixel * math.sqrt(dx * dx + dy * dy)
            column = x // cell_px
            out[low % bins, row, column] += (1.0 - share) * size
            out[(low + 1) % bins, row, column] += share * size
