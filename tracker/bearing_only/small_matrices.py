"""Compiled algebra of matrices so small that the call of a library costs more than the work.

For compiled code alone: Numba loses the type of what a cached function returns when it is called
from Python as well as from another cached function.
"""

from typing import TypeAlias

import numpy as np
from numba import njit

Three: TypeAlias = np.ndarray | tuple[float, float, float]


@njit(cache=True, error_model="numpy")
def dot(a: Three, b: Three) -> float:
    """Returns the scalar product of two vectors (3,)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, error_model="numpy")
def product(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """(n, m): A (n, k) times B (k, m)."""
    n, k, m = A.shape[0], A.shape[1], B.shape[1]
    C = np.empty((n, m))
    for i in range(n):
        for j in range(m):
            total = 0.0
            for t in range(k):
                total += A[i, t] * B[t, j]
            C[i, j] = total
    return C


@njit(cache=True, error_model="numpy")
def sandwich(A: np.ndarray, P: np.ndarray) -> np.ndarray:
    """(n, n): A (n, k) times P (k, k) times the transpose of A."""
    return product(product(A, P), A.T)


@njit(cache=True, error_model="numpy")
def inverse_and_determinant(S: np.ndarray) -> tuple[np.ndarray, float]:
    """Returns inverse and determinant of a (2, 2) matrix."""
    determinant = S[0, 0] * S[1, 1] - S[0, 1] * S[1, 0]
    return np.array([[S[1, 1], -S[0, 1]], [-S[1, 0], S[0, 0]]]) / determinant, determinant
