"""Residuals and derivatives of the joint fit: outline points, calyxes, and what is known before.

A hypothesis is the fruit (centre, log radius, log aspect, axis), how far an edge detector puts the
outline outwards, how deep the calyx sits, and for each view a small error of the camera's pose. All
hypotheses are evaluated at once; arrays lead with (hypothesis, view).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tracker.apple.attitude import tangent_basis, unit
from tracker.apple.spheroid import rays_of
from tracker.apple.view import Sighting
from tracker.checks import require_count, require_positive

SHARED = 9
"""Centre (3), log radius, log aspect, axis (2), edge offset, depth of the calyx."""
PER_VIEW = 6
"""Turn (3) and shift (3) of a camera, in units of their deviations."""

_CENTRE, _RADIUS, _ASPECT, _AXIS = slice(0, 3), 3, 4, slice(5, 7)
AXIS = _AXIS
_EDGE, _DEPTH = 7, 8
_GRAZING = 0.05
"""A normal that misses the model counts as touching it at this share of the slope."""
_WHOLE = 0.95
"""Share of the outline in sight from which a view without `skin_px` counts as bare skin."""


@dataclass(frozen=True)
class OutlineModelConfig:
    """What is known before the images, and the noise in them."""

    contour_sigma_px: float = 0.35
    """Deviation of an outline point across the outline."""
    contour_correlation_px: float = 4.0
    """Outline points nearer than this count as one."""
    edge_sigma_px: float = 0.5
    """Deviation of the outline as a whole, outwards or inwards, the same in all views."""
    pose_sigma_rad: float = 0.01
    """Deviation of a camera's orientation about each axis."""
    pose_sigma_m: float = 0.002
    """Deviation of a camera's position along each axis."""
    aspect: float = 0.9
    """Height divided by diameter of the fruits of this kind."""
    aspect_sigma: float = 0.06
    """Relative deviation of a fruit's aspect from that."""
    radius_m: float = 0.04
    """Equatorial radius of the fruits of this kind."""
    radius_sigma: float = 0.25
    """Relative deviation of a fruit's radius from that."""
    calyx_sigma: float = 0.06
    """Deviation of the calyx's middle in an image, as a share of the fruit's radius there."""
    depth_sigma: float = 0.03
    """Relative deviation of the calyx's distance from the middle of the fruit."""
    hidden_facing: float = 0.2
    """Cosine between the calyx's normal and the direction to the camera above which it is seen."""
    hidden_sigma: float = 0.1
    """How fast a calyx that ought to be seen, and is not, becomes improbable, in that cosine."""
    point_count: int = 64
    """Outline points of a view that are used; more are thinned out."""
    skin_count: int = 96
    """Points of bare skin of a view that are used; more are thinned out."""

    def __post_init__(self) -> None:
        names = [name for name in vars(self) if name not in ("point_count", "skin_count")]
        require_positive(self, *names)
        require_count(self, "point_count", "skin_count", least=8)


@dataclass(frozen=True, eq=False)
class Hypotheses:
    """Fruits and pose errors, S of them."""

    centre_m: np.ndarray
    """(S, 3)"""
    axis: np.ndarray
    """(S, 3) from calyx to stem."""
    log_radius: np.ndarray
    """(S,) of metres."""
    log_aspect: np.ndarray
    """(S,)"""
    edge_px: np.ndarray
    """(S,) outwards."""
    depth: np.ndarray
    """(S,) distance of the calyx from the middle, relative to half the fruit's height."""
    pose_error: np.ndarray
    """(S, V, 6) turn and shift of each camera in units of their deviations."""

    def moved(self, shared: np.ndarray, per_view: np.ndarray) -> Hypotheses:
        """After steps (S, 9) and (S, V, 6)."""
        tilt = (tangent_basis(self.axis) @ shared[:, _AXIS, None])[..., 0]
        return Hypotheses(
            self.centre_m + shared[:, _CENTRE],
            unit(self.axis + tilt),
            self.log_radius + shared[:, _RADIUS],
            self.log_aspect + shared[:, _ASPECT],
            self.edge_px + shared[:, _EDGE],
            self.depth + shared[:, _DEPTH],
            self.pose_error + per_view,
        )

    def where(self, chosen: np.ndarray, other: Hypotheses) -> Hypotheses:
        """These where `chosen` (S,), the others elsewhere."""
        return Hypotheses(
            *(
                np.where(chosen.reshape(-1, *[1] * (mine.ndim - 1)), mine, theirs)
                for mine, theirs in zip(vars(self).values(), vars(other).values(), strict=True)
            )
        )

    def take(self, index: np.ndarray) -> Hypotheses:
        """Those of an index array."""
        return Hypotheses(*(value[index] for value in vars(self).values()))

    def flipped(self) -> Hypotheses:
        """The same outlines with calyx and stem exchanged."""
        return replace(self, axis=-self.axis)


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


class OutlineModel:
    """The views as arrays, and what each hypothesis makes of them."""

    def __init__(self, sightings: Sequence[Sighting], config: OutlineModelConfig) -> None:
        self._config = config
        self._R = np.stack([sighting.pose.rotation for sighting in sightings])
        self._p = np.stack([sighting.pose.position_m for sighting in sightings])
        self._f = np.stack([np.diag(sighting.K)[:2] for sighting in sightings])
        self._principal = np.stack([sighting.K[:2, 2] for sighting in sightings])
        self._set_contours(sightings)
        self._set_calyxes(sightings)
        self.pose_sigmas = np.repeat([config.pose_sigma_rad, config.pose_sigma_m], 3)

    def _set_contours(self, sightings: Sequence[Sighting]) -> None:
        """Rays of outline points and their weights, 0 where a view has fewer than another."""
        config = self._config
        thinned = [_thinned(s.view.contour_px, config.point_count) for s in sightings]
        count = max(map(len, thinned))
        self._rays = np.tile([0.0, 0.0, 1.0], (len(sightings), count, 1))
        self._outward = np.tile([1.0, 0.0, 0.0], (len(sightings), count, 1))
        self._weights = np.zeros((len(sightings), count))
        for i, (sighting, points) in enumerate(zip(sightings, thinned, strict=True)):
            rays = rays_of(points, sighting.K)
            self._rays[i, : len(points)] = rays @ sighting.pose.rotation.T
            outward = _normals(sighting, points) / self._f[i]
            self._outward[i, : len(points)] = outward @ sighting.pose.rotation[:, :2].T
            if len(points):
                axes = sighting.view.semi_axes_px
                length = 2.0 * np.pi * (40.0 if axes is None else float(axes.mean()))
                spacing = length * sighting.view.arc_fraction / len(points)
                independent = min(1.0, spacing / config.contour_correlation_px)
                self._weights[i, : len(points)] = independent

    def _set_calyxes(self, sightings: Sequence[Sighting]) -> None:
        config = self._config
        seen = [sighting.view.calyx_px for sighting in sightings]
        self._has_calyx = np.array([calyx is not None for calyx in seen])
        self._calyx_px = np.array([np.zeros(2) if c is None else c for c in seen])
        sizes = [1.0 if (a := s.view.semi_axes_px) is None else float(a[0]) for s in sightings]
        self._calyx_sigma_px = config.calyx_sigma * np.array(sizes)
        thinned = [_thinned(s.view.skin_px, config.skin_count) for s in sightings]
        count = max(1, *map(len, thinned))
        self._skin_px = np.full((len(sightings), count, 2), np.inf)
        self._skin_reach_px = np.ones(len(sightings))
        for i, (sighting, points) in enumerate(zip(sightings, thinned, strict=True)):
            self._skin_px[i, : len(points)] = points
            if len(points):
                coarser = np.sqrt(len(sighting.view.skin_px) / len(points))
                self._skin_reach_px[i] = max(1.0, sighting.view.skin_step_px * coarser)
            elif sighting.view.arc_fraction >= _WHOLE and sighting.view.centre_px is not None:
                self._skin_px[i, 0], self._skin_reach_px[i] = sighting.view.centre_px, sizes[i]

    def evaluate(self, hypotheses: Hypotheses, scale_px: float) -> NormalEquations:
        """Cost and derivatives, outline points further off than `scale_px` losing their pull."""
        geometry = self._geometry(hypotheses)
        residual, J = self._outline(hypotheses, *geometry)
        weight = self._weights / self._config.contour_sigma_px**2
        loss = 1.0 / (1.0 + (residual / scale_px) ** 2)
        cost = 0.5 * (weight * residual**2 * loss).sum(axis=(1, 2))
        system = _accumulate(J, residual, weight * loss**2)
        for residual, J in (
            self._calyx(hypotheses, *geometry),
            self._hidden(hypotheses, *geometry),
        ):
            cost = cost + 0.5 * (residual**2).sum(axis=(1, 2))
            more = _accumulate(J, residual, np.ones(()))
            system = (system[0] + more[0], system[1] + more[1])
        return self._with_priors(hypotheses, cost, *system)

    def _geometry(self, hypotheses: Hypotheses) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Turns of the cameras (S, V, 3, 3), fruit from camera (S, V, 3), tangents (S, 3, 2)."""
        turned = _turn(hypotheses.pose_error[..., :3] * self._config.pose_sigma_rad)
        positions = self._p + hypotheses.pose_error[..., 3:] * self._config.pose_sigma_m
        to_fruit = hypotheses.centre_m[:, None] - positions
        return turned, to_fruit, tangent_basis(hypotheses.axis)

    def residual_px(self, hypotheses: Hypotheses) -> float:
        """Robust root mean square of the outline points' distances, of the first hypothesis."""
        residual = self._outline(hypotheses, *self._geometry(hypotheses))[0][0]
        known = np.abs(residual[self._weights > 0.0])
        return 1.4826 * float(np.median(known)) if len(known) else 0.0

    def _outline(
        self, hypotheses: Hypotheses, turned: np.ndarray, y: np.ndarray, E: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Distances [px] (S, V, n) from each outline point to the model, and derivatives.

        The distance is measured along the normal of the ellipse that was fitted to the view, above
        zero where the model lies further out. On such a line q is a parabola in the distance t, so
        t is exact, and so is dt/dθ = -(∂q/∂θ) / (∂q/∂t). (The Sampson distance q / |∇q| needs no
        normal, but with its norm held fixed in the derivatives it pulls noisy fits to one side.)
        """
        a = hypotheses.axis[:, None]
        aspect, radius = np.exp(hypotheses.log_aspect), np.exp(hypotheses.log_radius)
        g = (aspect**-2 - 1.0)[:, None]
        w = (y * a).sum(axis=-1)
        By = y + (g * w)[..., None] * a
        size = ((y * By).sum(axis=-1) - radius[:, None] ** 2)[..., None]
        turned_back = np.swapaxes(turned, -1, -2)
        d = self._rays @ turned_back  # (S, V, n, 3)
        out = self._outward @ turned_back
        g_a = g[..., None]
        u, v = (d @ a[..., None])[..., 0], (out @ a[..., None])[..., 0]
        dBy, vBy = (d @ By[..., None])[..., 0], (out @ By[..., None])[..., 0]
        bend = vBy**2 - size * ((out**2).sum(axis=-1) + g_a * v**2)
        slope = dBy * vBy - size * ((d * out).sum(axis=-1) + g_a * u * v)
        value = dBy**2 - size * ((d**2).sum(axis=-1) + g_a * u**2)
        root = np.sqrt(np.maximum(slope**2 - bend * value, (_GRAZING * slope) ** 2))
        t = value / np.maximum(root - slope, 1e-12)
        d = d + t[..., None] * out
        u, dBy = u + t * v, dBy + t * vBy
        dBd = (d**2).sum(axis=-1) + g_a * u**2
        wn = w[..., None]
        scale = 0.5 / root
        Bd = d + (g_a * u)[..., None] * a[:, :, None]
        by_d = (2.0 * scale)[..., None] * (
            dBy[..., None] * By[:, :, None] - size[..., None] * Bd
        )
        by_y = (2.0 * scale)[..., None] * (dBy[..., None] * Bd - dBd[..., None] * By[:, :, None])
        of_d, of_y = (dBy * wn - size * u), (dBy * u - dBd * wn)
        by_a = (2.0 * g_a * scale)[..., None] * (
            of_d[..., None] * d + of_y[..., None] * y[:, :, None]
        )
        J = np.empty((*t.shape, SHARED + PER_VIEW))
        J[..., _CENTRE] = by_y
        J[..., _RADIUS] = 2.0 * radius[:, None, None] ** 2 * dBd * scale
        by_g = 2.0 * dBy * u * wn - wn**2 * dBd - size * u**2
        J[..., _ASPECT] = -2.0 * (aspect**-2)[:, None, None] * by_g * scale
        J[..., _AXIS] = by_a @ E[:, None]
        J[..., _EDGE] = 1.0
        J[..., _DEPTH] = 0.0
        J[..., SHARED : SHARED + 3] = np.cross(d, by_d) * self.pose_sigmas[:3]
        J[..., SHARED + 3 :] = -by_y * self.pose_sigmas[3:]
        return t + hypotheses.edge_px[:, None, None], J

    def _calyx(
        self, hypotheses: Hypotheses, turned: np.ndarray, y: np.ndarray, E: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Differences (S, V, 2), in deviations, of seen calyxes, and (S, V, 2, 15) derivatives."""
        pixel, J = self._calyx_pixel(hypotheses, turned, y, E)
        scale = (self._has_calyx / self._calyx_sigma_px)[:, None]
        return (pixel - self._calyx_px) * scale, J * scale[..., None]

    def _calyx_pixel(
        self, hypotheses: Hypotheses, turned: np.ndarray, y: np.ndarray, E: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Where each view shows the calyx (S, V, 2), and (S, V, 2, 15) derivatives."""
        a = hypotheses.axis[:, None]
        reach = (np.exp(hypotheses.log_radius + hypotheses.log_aspect) * hypotheses.depth)[:, None]
        pole = y - reach[..., None] * a
        rotation = turned @ self._R
        x = (pole[..., None, :] @ rotation)[..., 0, :]
        flat = x[..., :2] / x[..., 2:]
        by_pole = np.swapaxes(rotation, -1, -2)
        by_pole = (by_pole[..., :2, :] - flat[..., None] * by_pole[..., 2:, :]) / x[..., 2:, None]
        by_pole = by_pole * self._f[:, :, None]
        outward = -(by_pole @ a[..., None])[..., 0] * reach[..., None]
        J = np.empty((*flat.shape, SHARED + PER_VIEW))
        J[..., _CENTRE] = by_pole
        J[..., _RADIUS] = J[..., _ASPECT] = outward
        J[..., _AXIS] = -reach[..., None, None] * (by_pole @ E[:, None])
        J[..., _EDGE] = 0.0
        J[..., _DEPTH] = outward / hypotheses.depth[:, None, None]
        turning = np.cross(by_pole, pole[..., None, :])
        J[..., SHARED : SHARED + 3] = turning * self.pose_sigmas[:3]
        J[..., SHARED + 3 :] = -by_pole * self.pose_sigmas[3:]
        return flat * self._f + self._principal, J

    def _hidden(
        self, hypotheses: Hypotheses, turned: np.ndarray, y: np.ndarray, E: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """One-sided: a calyx that faces the camera where bare skin is in sight is not there."""
        a = hypotheses.axis[:, None]
        reach = np.exp(hypotheses.log_radius + hypotheses.log_aspect)[:, None, None]
        pole = y - reach * a
        distance = np.linalg.norm(pole, axis=-1)
        toward = pole / distance[..., None]
        facing = (toward * a).sum(axis=-1)
        excess = np.maximum(0.0, facing - self._config.hidden_facing)
        by_pole = (a - facing[..., None] * toward) / distance[..., None]
        J = np.zeros((*facing.shape, 1, SHARED + PER_VIEW))
        J[..., 0, _AXIS] = ((toward - reach * by_pole)[..., None, :] @ E[:, None])[..., 0, :]
        scale = self._on_skin(hypotheses, turned, y, E) / self._config.hidden_sigma
        scale = np.where(excess > 0.0, scale, 0.0)
        return (excess * scale)[..., None], J * scale[..., None, None]

    def _on_skin(
        self, hypotheses: Hypotheses, turned: np.ndarray, y: np.ndarray, E: np.ndarray
    ) -> np.ndarray:
        """(S, V) whether the calyx would lie on bare skin, in views that show none."""
        pixel, _ = self._calyx_pixel(hypotheses, turned, y, E)
        distance = np.abs(pixel[:, :, None] - self._skin_px).max(axis=-1).min(axis=-1)
        return (distance <= self._skin_reach_px) & ~self._has_calyx

    def _with_priors(
        self, hypotheses: Hypotheses, cost: np.ndarray, matrix: np.ndarray, gradient: np.ndarray
    ) -> NormalEquations:
        """Adds what is known before the images, and parts the views' own parameters."""
        config = self._config
        off = np.zeros((len(cost), SHARED))
        inverse = np.zeros(SHARED)
        inverse[[_RADIUS, _ASPECT, _EDGE, _DEPTH]] = [
            1.0 / config.radius_sigma,
            1.0 / config.aspect_sigma,
            1.0 / config.edge_sigma_px,
            1.0 / config.depth_sigma,
        ]
        off[:, _RADIUS] = hypotheses.log_radius - np.log(config.radius_m)
        off[:, _ASPECT] = hypotheses.log_aspect - np.log(config.aspect)
        off[:, _EDGE], off[:, _DEPTH] = hypotheses.edge_px, hypotheses.depth - 1.0
        off *= inverse
        error = hypotheses.pose_error
        shared = matrix[..., :SHARED, :SHARED].sum(axis=1) + np.diag(inverse**2)
        return NormalEquations(
            cost=cost + 0.5 * (off**2).sum(axis=1) + 0.5 * (error**2).sum(axis=(1, 2)),
            shared_gradient=gradient[..., :SHARED].sum(axis=1) + off * inverse,
            shared_matrix=shared,
            view_gradient=gradient[..., SHARED:] + error,
            view_matrix=matrix[..., SHARED:, SHARED:] + np.eye(PER_VIEW),
            mixed_matrix=matrix[..., SHARED:, :SHARED],
        )


def _accumulate(
    J: np.ndarray, residual: np.ndarray, weight: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(S, V, 15, 15) and (S, V, 15): JᵀWJ and JᵀWr of each view."""
    weighted = np.swapaxes(J * np.broadcast_to(weight, residual.shape)[..., None], -1, -2)
    return weighted @ J, (weighted @ residual[..., None])[..., 0]


def _turn(vectors: np.ndarray) -> np.ndarray:
    """(..., 3, 3) rotations by small vectors (..., 3) [rad].

    To the second order and made orthonormal enough: what is left out is below 1e-6 for 1 degree.
    """
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    skew = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1)
    skew = skew.reshape(*x.shape, 3, 3)
    return np.eye(3) + skew + 0.5 * (skew @ skew)


def _normals(sighting: Sighting, points: np.ndarray) -> np.ndarray:
    """(n, 2) unit normals, outwards, of the view's ellipse at points near it."""
    view = sighting.view
    assert view.centre_px is not None and view.semi_axes_px is not None
    assert view.major_angle_rad is not None
    c, s = np.cos(view.major_angle_rad), np.sin(view.major_angle_rad)
    axes = np.array([[c, s], [-s, c]])
    gradient = ((points - view.centre_px) @ axes.T / view.semi_axes_px**2) @ axes
    return gradient / np.maximum(np.linalg.norm(gradient, axis=1, keepdims=True), 1e-12)


def _thinned(points: np.ndarray, count: int) -> np.ndarray:
    """At most so many of the points, evenly chosen."""
    if len(points) <= count:
        return points
    return points[np.linspace(0, len(points) - 1, count).round().astype(int)]
