"""Compiled Cholesky solves of many small symmetric systems.

LAPACK's overhead on a 6 x 6 matrix exceeds its arithmetic. Compiled at first use, cached on disk.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy")
def factorise(A: np.ndarray, out: np.ndarray) -> None:
    """Lower Cholesky factors (n, d, d) of positive definite A (n, d, d); NaN where A is not."""
    d = A.shape[1]
    for i in range(len(A)):
        for row in range(d):
            for column in range(row + 1):
                rest = A[i, row, column]
                for k in range(column):
                    rest -= out[i, row, k] * out[i, column, k]
                if row > column:
                    out[i, row, column] = rest / out[i, column, column]
                else:
                    out[i, row, row] = math.sqrt(rest) if rest > 0.0 else math.nan
            out[i, row, row + 1 :] = 0.0


@njit(cache=True, error_model="numpy")
def solve_lower(root: np.ndarray, b: np.ndarray, out: np.ndarray) -> None:
    """x (n, d) of `L x = b`."""
    for i in range(len(b)):
        for row in range(b.shape[1]):
            rest = b[i, row]
            for k in range(row):
                rest -= root[i, row, k] * out[i, k]
            out[i, row] = rest / root[i, row, row]


@njit(cache=True, error_model="numpy")
def solve_upper(root: np.ndarray, b: np.ndarray, out: np.ndarray) -> None:
    """x (n, d) of `L^T x = b`."""
    d = b.shape[1]
    for i in range(len(b)):
        for row in range(d - 1, -1, -1):
            rest = b[i, row]
            for k in range(row + 1, d):
                rest -= root[i, k, row] * out[i, k]
            out[i, row] = rest / root[i, row, row]
