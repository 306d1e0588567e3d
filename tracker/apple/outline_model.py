"""Residuals and derivatives of the joint fit: outline points, calyxes, and what is known before.

A hypothesis is the fruit (centre, log radius, log aspect, axis), how far an edge detector puts the
outline outwards, how deep the calyx sits, and for each view a small error of the camera's pose. All
hypotheses are evaluated at once; arrays lead with (hypothesis, view).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tracker.apple.attitude import tangent_basis, unit
from tracker.apple.spheroid import rays_of
from tracker.apple.view import FruitView, Sighting
from tracker.checks import require_count, require_positive

SHARED = 9
"""Centre (3), log radius, log aspect, axis (2), edge offset, depth of the calyx."""
PER_VIEW = 6
"""Turn (3) and shift (3) of a camera, in units of their deviations."""

_CENTRE, _RADIUS, _ASPECT, _AXIS = slice(0, 3), 3, 4, slice(5, 7)
AXIS = _AXIS
_EDGE, _DEPTH = 7, 8
_TURN, _SHIFT = slice(SHARED, SHARED + 3), slice(SHARED + 3, SHARED + 6)
_GRAZING = 0.05
"""A normal that misses the model counts as touching it at this share of the slope."""
_ELLIPSE_POINTS = 64
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
        thinned = [_thinned(_outline_points(s.view), config.point_count) for s in sightings]
        count = max(map(len, thinned))
        self._rays = np.tile([[0.0], [0.0], [1.0]], (len(sightings), 1, count))
        self._outward = np.tile([[1.0], [0.0], [0.0]], (len(sightings), 1, count))
        self._weights = np.zeros((len(sightings), count))
        for i, (sighting, points) in enumerate(zip(sightings, thinned, strict=True)):
            n, R = len(points), sighting.pose.rotation
            self._rays[i, :, :n] = R @ rays_of(points, sighting.K).T
            self._outward[i, :, :n] = R[:, :2] @ (_normals(sighting.view, points) / self._f[i]).T
            spacing = _arc_length_px(sighting.view) / max(1, n)
            self._weights[i, :n] = min(1.0, spacing / config.contour_correlation_px)

    def _set_calyxes(self, sightings: Sequence[Sighting]) -> None:
        config = self._config
        views = [sighting.view for sighting in sightings]
        self._has_calyx = np.array([view.calyx_px is not None for view in views])
        self._calyx_px = np.array([np.zeros(2) if (c := v.calyx_px) is None else c for v in views])
        sizes = np.array([_ellipse(view)[1][0] for view in views])
        self._calyx_inverse = self._has_calyx / (config.calyx_sigma * sizes)
        thinned = [_thinned(view.skin_px, config.skin_count) for view in views]
        self._skin_px = np.full((len(views), max(1, *map(len, thinned)), 2), np.inf)
        self._skin_reach_px = np.ones(len(views))
        for i, (view, points) in enumerate(zip(views, thinned, strict=True)):
            self._skin_px[i, : len(points)] = points
            if len(points):
                coarser = np.sqrt(len(view.skin_px) / len(points))
                self._skin_reach_px[i] = max(1.0, view.skin_step_px * coarser)
            elif view.arc_fraction >= _WHOLE:
                self._skin_px[i, 0], self._skin_reach_px[i] = _ellipse(view)[0], sizes[i]

    def evaluate(self, hypotheses: Hypotheses, scale_px: float) -> NormalEquations:
        """Cost and derivatives, outline points further off than `scale_px` losing their pull."""
        geometry = self._geometry(hypotheses)
        distance, J = self._outline(hypotheses, *geometry)
        weight = self._weights / self._config.contour_sigma_px**2
        loss = 1.0 / (1.0 + (distance / scale_px) ** 2)
        cost = 0.5 * (weight * distance**2 * loss).sum(axis=(1, 2))
        weighted = J * (weight * loss**2)[..., None, :]
        off, pole_J = self._poles(hypotheses, *geometry)
        cost += 0.5 * (off**2).sum(axis=(1, 2))
        matrix = weighted @ np.swapaxes(J, -1, -2) + pole_J @ np.swapaxes(pole_J, -1, -2)
        gradient = (weighted @ distance[..., None] + pole_J @ off[..., None])[..., 0]
        return self._with_priors(hypotheses, cost, matrix, gradient)

    def residual_px(self, hypotheses: Hypotheses) -> float:
        """Robust root mean square of the outline points' distances, of the first hypothesis."""
        distance = self._outline(hypotheses, *self._geometry(hypotheses))[0][0]
        known = np.abs(distance[self._weights > 0.0])
        return 1.4826 * float(np.median(known)) if len(known) else 0.0

    def _geometry(self, hypotheses: Hypotheses) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Turns of the cameras (S, V, 3, 3), fruit from camera (S, V, 3), tangents (S, 3, 2)."""
        turned = _turn(hypotheses.pose_error[..., :3] * self._config.pose_sigma_rad)
        positions = self._p + hypotheses.pose_error[..., 3:] * self._config.pose_sigma_m
        to_fruit = hypotheses.centre_m[:, None] - positions
        return turned, to_fruit, tangent_basis(hypotheses.axis)

    def _outline(
        self, hypotheses: Hypotheses, turned: np.ndarray, y: np.ndarray, E: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Distances [px] (S, V, n) from outline points to the model, (S, V, 15, n) derivatives.

        The distance is measured along the normal of the ellipse that was fitted to the view, above
        zero where the model lies further out. On such a line q is a parabola in the distance t, so
        t is exact, and so is dt/dθ = -(∂q/∂θ) / (∂q/∂t). (The Sampson distance q / |∇q| needs no
        normal, but with its norm held fixed in the derivatives it pulls noisy fits to one side.)
        """
        a = hypotheses.axis[:, None, None, :]
        aspect = np.exp(hypotheses.log_aspect)[:, None, None]
        square = np.exp(2.0 * hypotheses.log_radius)[:, None, None]
        g = aspect**-2 - 1.0
        w = y[..., None, :] @ np.swapaxes(a, -1, -2)  # (S, V, 1, 1)
        By = y + (g * w[..., 0]) * a[:, :, 0]
        w = w[..., 0]
        size = (y * By).sum(axis=-1, keepdims=True) - square
        d, out = turned @ self._rays, turned @ self._outward  # (S, V, 3, n)
        u, v = (a @ d)[..., 0, :], (a @ out)[..., 0, :]
        dBy, vBy = (By[..., None, :] @ d)[..., 0, :], (By[..., None, :] @ out)[..., 0, :]
        bend = vBy**2 - size * ((out**2).sum(axis=-2) + g * v**2)
        slope = dBy * vBy - size * ((d * out).sum(axis=-2) + g * u * v)
        value = dBy**2 - size * ((d**2).sum(axis=-2) + g * u**2)
        root = np.sqrt(np.maximum(slope**2 - bend * value, (_GRAZING * slope) ** 2))
        t = value / np.maximum(root - slope, 1e-12)
        d += t[..., None, :] * out
        u += t * v
        dBy += t * vBy
        dBd = (d**2).sum(axis=-2) + g * u**2
        scale = 1.0 / root  # ½ ∂q/∂θ / root: the halves cancel
        dBy_s, size_s, dBd_s = dBy * scale, size * scale, dBd * scale
        Bd = d + (g * u)[..., None, :] * hypotheses.axis[:, None, :, None]
        by_d = dBy_s[..., None, :] * By[..., None] - size_s[..., None, :] * Bd
        by_y = dBy_s[..., None, :] * Bd - dBd_s[..., None, :] * By[..., None]
        along_d, along_y = g * (dBy_s * w - size_s * u), g * (dBy_s * u - dBd_s * w)
        E_T = np.swapaxes(E, -1, -2)[:, None]
        J = np.empty((*t.shape[:2], SHARED + PER_VIEW, t.shape[2]))
        J[..., _CENTRE, :] = by_y
        J[..., _RADIUS, :] = square * dBd_s
        J[..., _ASPECT, :] = -(aspect**-2) * (2.0 * dBy_s * u * w - w**2 * dBd_s - size_s * u**2)
        J[..., _AXIS, :] = along_d[..., None, :] * (E_T @ d) + along_y[..., None, :] * (
            E_T @ y[..., None]
        )
        J[..., _EDGE, :] = 1.0
        J[..., _DEPTH, :] = 0.0
        J[..., _TURN, :] = _cross(d, by_d) * self.pose_sigmas[:3, None]
        J[..., _SHIFT, :] = -by_y * self.pose_sigmas[3:, None]
        return t + hypotheses.edge_px[:, None, None], J

    def _poles(
        self, hypotheses: Hypotheses, turned: np.ndarray, y: np.ndarray, E: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """What the calyxes say (S, V, 3), in deviations, and (S, V, 15, 3) derivatives.

        Two are the difference to a calyx in sight. The third is one-sided: where none is, it must
        not face the camera at a place where bare skin is in sight.
        """
        pixel, pixel_J = self._calyx_pixel(hypotheses, turned, y, E)
        off = np.empty((*pixel.shape[:2], 3))
        J = np.zeros((*pixel.shape[:2], SHARED + PER_VIEW, 3))
        off[..., :2] = (pixel - self._calyx_px) * self._calyx_inverse[:, None]
        J[..., :2] = np.swapaxes(pixel_J * self._calyx_inverse[:, None, None], -1, -2)
        a = hypotheses.axis[:, None]
        reach = np.exp(hypotheses.log_radius + hypotheses.log_aspect)[:, None, None]
        pole = y - reach * a
        distance = np.linalg.norm(pole, axis=-1, keepdims=True)
        toward = pole / distance
        facing = (toward * a).sum(axis=-1)
        excess = facing - self._config.hidden_facing
        near = np.abs(pixel[:, :, None] - self._skin_px).max(axis=-1).min(axis=-1)
        is_wrong = (excess > 0.0) & ~self._has_calyx & (near <= self._skin_reach_px)
        scale = is_wrong / self._config.hidden_sigma
        off[..., 2] = excess * scale
        by_axis = toward - reach * (a - facing[..., None] * toward) / distance
        J[..., _AXIS, 2] = (by_axis @ E) * scale[..., None]
        return off, J

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
        J[..., _TURN] = np.cross(by_pole, pole[..., None, :]) * self.pose_sigmas[:3]
        J[..., _SHIFT] = -by_pole * self.pose_sigmas[3:]
        return flat * self._f + self._principal, J

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


def _cross(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Cross products of vectors (..., 3, n) along the last axis but one; faster than NumPy's."""
    x, y, z = (first[..., i, :] for i in range(3))
    X, Y, Z = (second[..., i, :] for i in range(3))
    return np.stack([y * Z - z * Y, z * X - x * Z, x * Y - y * X], axis=-2)


def _turn(vectors: np.ndarray) -> np.ndarray:
    """(..., 3, 3) rotations by small vectors (..., 3) [rad].

    To the second order and made orthonormal enough: what is left out is below 1e-6 for 1 degree.
    """
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    skew = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1)
    skew = skew.reshape(*x.shape, 3, 3)
    return np.eye(3) + skew + 0.5 * (skew @ skew)


def _ellipse(view: FruitView) -> tuple[np.ndarray, np.ndarray, float]:
    """Centre, semi-axes and angle of the major axis of a view with a fruit."""
    if view.centre_px is None or view.semi_axes_px is None or view.major_angle_rad is None:
        raise ValueError(f"no fruit to use in this view: {view.status}")
    return view.centre_px, view.semi_axes_px, view.major_angle_rad


def _outline_points(view: FruitView) -> np.ndarray:
    """(n, 2) the points that were found, or the ellipse's where a view tells none."""
    if len(view.contour_px):
        return view.contour_px
    centre, semi_axes, angle = _ellipse(view)
    turn = np.linspace(0.0, 2.0 * math.pi, _ELLIPSE_POINTS, endpoint=False)
    c, s = math.cos(angle), math.sin(angle)
    along = semi_axes * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    return centre + along @ np.array([[c, s], [-s, c]])


def _arc_length_px(view: FruitView) -> float:
    return 2.0 * math.pi * float(_ellipse(view)[1].mean()) * view.arc_fraction


def _normals(view: FruitView, points: np.ndarray) -> np.ndarray:
    """(n, 2) unit normals, outwards, of the view's ellipse at points near it."""
    centre, semi_axes, angle = _ellipse(view)
    c, s = math.cos(angle), math.sin(angle)
    axes = np.array([[c, s], [-s, c]])
    gradient = ((points - centre) @ axes.T / semi_axes**2) @ axes
    return gradient / np.maximum(np.linalg.norm(gradient, axis=1, keepdims=True), 1e-12)


def _thinned(points: np.ndarray, count: int) -> np.ndarray:
    """At most so many of the points, evenly chosen."""
    if len(points) <= count:
        return points
    return points[np.linspace(0, len(points) - 1, count).round().astype(int)]
