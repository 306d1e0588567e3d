"""Where the normals of measured outlines meet the outline of a spheroid, and how that point moves.

With q(d) of `spheroid`, the rays d + t·out along a pixel normal `out` give a parabola in t [px], so
the distance t to the model's outline is exact, and so is dt/dθ = -(∂q/∂θ) / (∂q/∂t). (The Sampson
distance q / |∇q| needs no normal, but with its norm held fixed in the derivatives it pulls noisy
fits to one side: the radius came out 6 % too small.)
"""

from dataclasses import dataclass

import numpy as np

from tracker.apple.hypotheses import Hypotheses

_GRAZING = 0.05
"""A normal that misses the model counts as touching it at this share of the slope."""


@dataclass(frozen=True, eq=False)
class Meetings:
    """The points where S models meet the normals of n outline points in V views.

    Derivatives are those of the distance: ∂q/∂θ times `scale`, in which both factors ½ are gone.
    """

    distance_px: np.ndarray
    """(S, V, n) along the normal, above zero where the model lies further out."""
    d: np.ndarray
    """(S, V, 3, n) rays to these points."""
    a: np.ndarray
    """(S, 1, 3, 1) axes."""
    y: np.ndarray
    """(S, V, 3, 1) fruit from camera."""
    By: np.ndarray
    """(S, V, 3, 1)"""
    g: np.ndarray
    """(S, 1, 1) 1/k² - 1"""
    square: np.ndarray
    """(S, 1, 1) r²"""
    size: np.ndarray
    """(S, V, n) yᵀBy - r², times scale"""
    dBy: np.ndarray
    """(S, V, n) dᵀBy, times scale"""
    dBd: np.ndarray
    """(S, V, n) dᵀBd, times scale"""
    u: np.ndarray
    """(S, V, n) aᵀd"""
    w: np.ndarray
    """(S, V, 1) aᵀy"""

    def by_ray(self) -> np.ndarray:
        """(S, V, 3, n) by d."""
        return _row(self.dBy) * self.By - _row(self.size) * self._Bd

    def by_fruit(self) -> np.ndarray:
        """(S, V, 3, n) by y."""
        return _row(self.dBy) * self._Bd - _row(self.dBd) * self.By

    def by_axis(self) -> tuple[np.ndarray, np.ndarray]:
        """(S, V, n) and (S, V, n): how much of d and of y the derivative by a consists of."""
        along_d = self.g * (self.dBy * self.w - self.size * self.u)
        return along_d, self.g * (self.dBy * self.u - self.dBd * self.w)

    def by_log_radius(self) -> np.ndarray:
        """(S, V, n) by log r."""
        return self.square * self.dBd

    def by_log_aspect(self) -> np.ndarray:
        """(S, V, n) by log k; dg / d log k = -2 / k² = -2 (1 + g)."""
        by_g = 2.0 * self.dBy * self.u * self.w - self.w**2 * self.dBd - self.size * self.u**2
        return -(1.0 + self.g) * by_g

    @property
    def _Bd(self) -> np.ndarray:
        return self.d + _row(self.g * self.u) * self.a


def meet_outline(
    hypotheses: Hypotheses, y: np.ndarray, rays: np.ndarray, outward: np.ndarray
) -> Meetings:
    """Follows each normal to the model's outline.

    Args:
        hypotheses: S of them.
        y: (S, V, 3) fruit from camera.
        rays: (S, V, 3, n) to the outline points.
        outward: (S, V, 3, n) change of a ray one pixel along the normal.
    """
    a = hypotheses.axis[:, None, :, None]
    g = (np.exp(-2.0 * hypotheses.log_aspect) - 1.0)[:, None, None]
    square = np.exp(2.0 * hypotheses.log_radius)[:, None, None]
    y = y[..., None]
    a_T = np.swapaxes(a, -1, -2)
    w = (a_T @ y)[..., 0]
    By = y + _row(g * w) * a
    By_T = np.swapaxes(By, -1, -2)
    size = (y * By).sum(axis=-2) - square
    u, v = (a_T @ rays)[..., 0, :], (a_T @ outward)[..., 0, :]
    dBy, vBy = (By_T @ rays)[..., 0, :], (By_T @ outward)[..., 0, :]
    bend = vBy**2 - size * ((outward**2).sum(axis=-2) + g * v**2)
    slope = dBy * vBy - size * ((rays * outward).sum(axis=-2) + g * u * v)
    value = dBy**2 - size * ((rays**2).sum(axis=-2) + g * u**2)
    root = np.sqrt(np.maximum(slope**2 - bend * value, (_GRAZING * slope) ** 2))
    t = value / np.maximum(root - slope, 1e-12)
    d, u, dBy, scale = rays + _row(t) * outward, u + t * v, dBy + t * vBy, 1.0 / root
    dBd = ((d**2).sum(axis=-2) + g * u**2) * scale
    return Meetings(t, d, a, y, By, g, square, size * scale, dBy * scale, dBd, u, w)


def _row(values: np.ndarray) -> np.ndarray:
    """(..., n) as (..., 1, n)."""
    return values[..., None, :]
