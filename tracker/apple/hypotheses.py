"""Explanations of the images, many at once, and the normal equations of their least squares.

Arrays lead with the hypothesis (S of them) and, where each view has its own, the view (V).
"""

from dataclasses import dataclass, fields
from typing import Self, TypeVar

import numpy as np

from tracker.apple.attitude import tangent_basis, unit

SHARED = 9
"""Parameters that all views share, at these places in a step or a derivative:"""
CENTRE, LOG_RADIUS, LOG_ASPECT, AXIS, EDGE, DEPTH = slice(0, 3), 3, 4, slice(5, 7), 7, 8
PER_VIEW = 6
"""Turn (3) and shift (3) of a camera, in units of their deviations, which follow:"""
TURN, SHIFT = slice(SHARED, SHARED + 3), slice(SHARED + 3, SHARED + PER_VIEW)


@dataclass(frozen=True, eq=False)
class Hypotheses:
    """Fruits and pose errors, S of them."""

    centre_m: np.ndarray
    """(S, 3) middle of the fruit in the robot's frame."""
    axis: np.ndarray
    """(S, 3) unit vectors from calyx to stem."""
    log_radius: np.ndarray
    """(S,) logarithm of the equatorial radius [m]."""
    log_aspect: np.ndarray
    """(S,) logarithm of height over diameter."""
    edge_px: np.ndarray
    """(S,) shift of all outlines, outwards."""
    depth: np.ndarray
    """(S,) distance of the calyx from the middle, relative to half the fruit's height."""
    pose_error: np.ndarray
    """(S, V, 6) turn and shift of each camera in units of their deviations."""

    def moved(self, shared: np.ndarray, per_view: np.ndarray) -> Self:
        """Returns the hypotheses after steps (S, 9) and (S, V, 6)."""
        tilt = (tangent_basis(self.axis) @ shared[:, AXIS, None])[..., 0]
        return type(self)(
            self.centre_m + shared[:, CENTRE],
            unit(self.axis + tilt),
            self.log_radius + shared[:, LOG_RADIUS],
            self.log_aspect + shared[:, LOG_ASPECT],
            self.edge_px + shared[:, EDGE],
            self.depth + shared[:, DEPTH],
            self.pose_error + per_view,
        )

    def take(self, index: np.ndarray) -> Self:
        """Returns the hypotheses of an index array."""
        return type(self)(*(array[index] for array in arrays_of(self)))


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """Cost, gradient and Gauss-Newton matrix of S hypotheses, the views' own parameters apart."""

    cost: np.ndarray
    """(S,) half the sum of squares, robust."""
    shared_gradient: np.ndarray
    """(S, 9)"""
    shared_matrix: np.ndarray
    """(S, 9, 9)"""
    view_gradient: np.ndarray
    """(S, V, 6)"""
    view_matrix: np.ndarray
    """(S, V, 6, 6)"""
    mixed_matrix: np.ndarray
    """(S, V, 6, 9)"""


Arrays = TypeVar("Arrays", Hypotheses, NormalEquations)


def chosen_of(chosen: np.ndarray, first: Arrays, second: Arrays) -> Arrays:
    """Returns the first array where `chosen` (S,), the second elsewhere."""
    pairs = zip(arrays_of(first), arrays_of(second), strict=True)
    return type(first)(*(np.where(chosen.reshape(-1, *[1] * (a.ndim - 1)), a, b) for a, b in pairs))


def arrays_of(fitted: Hypotheses | NormalEquations) -> list[np.ndarray]:
    """All arrays, in the order of the fields."""
    return [getattr(fitted, field.name) for field in fields(fitted)]


def without_views(system: NormalEquations) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Matrix (S, 9, 9) and gradient (S, 9) of the shared parameters, views eliminated.

    Also what brings the views' parameters back: (S, V, 6, 9) and (S, V, 6).
    """
    mixed = system.mixed_matrix
    right = np.concatenate([mixed, system.view_gradient[..., None]], axis=-1)
    back = solved(system.view_matrix, right)
    eliminated, rest = back[..., :-1], back[..., -1]
    transposed = np.swapaxes(mixed, -1, -2)
    matrix = system.shared_matrix - (transposed @ eliminated).sum(axis=1)
    gradient = system.shared_gradient - (transposed @ rest[..., None])[..., 0].sum(axis=1)
    return matrix, gradient, eliminated, rest


def solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solutions (..., n, m) of systems (..., n, n), NumPy's return type made known."""
    return np.asarray(np.linalg.solve(matrix, right))
