"""The joint fit of outline points, calyxes and what is known before: derivatives, and its steps.

A hypothesis is the fruit (centre, log radius, log aspect, axis), how far an edge detector puts the
outline outwards, how deep the calyx sits, and for each view a small error of the camera's pose. All
hypotheses are evaluated at once.
"""

from collections.abc import Sequence

import numpy as np

from tracker.apple.attitude import tangent_basis
from tracker.apple.hypotheses import (
    AXIS,
    CENTRE,
    DEPTH,
    EDGE,
    LOG_ASPECT,
    LOG_RADIUS,
    PER_VIEW,
    SHARED,
    SHIFT,
    TURN,
    Hypotheses,
    NormalEquations,
    chosen_of,
    solved,
    without_views,
)
from tracker.apple.outline_rays import meet_outline
from tracker.apple.outline_views import OutlineModelConfig, OutlineViews
from tracker.apple.view import Sighting

_LONGEST_TILT = 0.5
"""Longest turn of the axis in one step [rad]."""
_SMALL_GAIN = 1e-3
"""Steps that lower half the sum of squares by less are the last ones."""
_STUCK = 1e4
"""A hypothesis that needs more damping is at rest."""


class OutlineModel:
    """What each hypothesis makes of the views."""

    def __init__(self, sightings: Sequence[Sighting], config: OutlineModelConfig) -> None:
        self._config = config
        self._views = OutlineViews(sightings, config)
        self._sigmas = np.repeat([config.pose_sigma_rad, config.pose_sigma_m], 3)

    def evaluate(self, hypotheses: Hypotheses, scale_px: float) -> NormalEquations:
        """Cost and derivatives, outline points further off than `scale_px` losing their pull.

        The loss is that of Geman and McClure: ½ w t² / (1 + t² / scale²).
        """
        geometry = self._geometry(hypotheses)
        distance, J = self.outline(hypotheses, *geometry)
        weight = self._views.weight
        loss = 1.0 / (1.0 + (distance / scale_px) ** 2)
        cost = 0.5 * (weight * distance**2 * loss).sum(axis=(1, 2))
        weighted = J * (weight * loss**2)[..., None, :]
        off, pole_J = self.poles(hypotheses, *geometry)
        cost += 0.5 * (off**2).sum(axis=(1, 2))
        matrix = weighted @ np.swapaxes(J, -1, -2) + pole_J @ np.swapaxes(pole_J, -1, -2)
        gradient = (weighted @ distance[..., None] + pole_J @ off[..., None])[..., 0]
        return self._with_priors(hypotheses, cost, matrix, gradient)

    def information(self, hypotheses: Hypotheses) -> np.ndarray:
        """(S, 9, 9) information of the views on each hypothesis, their pose errors eliminated."""
        system = self.evaluate(hypotheses, np.inf)
        return without_views(system)[0] - np.diag(self._prior_inverse() ** 2)

    def residual_px(self, hypotheses: Hypotheses) -> float:
        """Robust root mean square of the outline points' distances, of the first hypothesis."""
        distance = self.outline(hypotheses, *self._geometry(hypotheses))[0][0]
        return 1.4826 * float(np.median(np.abs(distance[self._views.weight > 0.0])))

    def _geometry(self, hypotheses: Hypotheses) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Turns of the cameras (S, V, 3, 3), fruit from camera (S, V, 3), tangents (S, 3, 2)."""
        turned = _turn(hypotheses.pose_error[..., :3] * self._config.pose_sigma_rad)
        positions = self._views.position_m + (
            hypotheses.pose_error[..., 3:] * self._config.pose_sigma_m
        )
        to_fruit = hypotheses.centre_m[:, None] - positions
        return turned, to_fruit, tangent_basis(hypotheses.axis)

    def outline(
        self, hypotheses: Hypotheses, turned: np.ndarray, y: np.ndarray, E: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Distances [px] (S, V, n) of the outline points, and (S, V, 15, n) derivatives.

        Above zero where the model lies further out than the point (`outline_rays`).
        """
        met = meet_outline(hypotheses, y, turned @ self._views.rays, turned @ self._views.outward)
        E_T = np.swapaxes(E, -1, -2)[:, None]
        by_d, by_y = met.by_ray(), met.by_fruit()
        along_d, along_y = met.by_axis()
        J = np.empty((*met.distance_px.shape[:2], SHARED + PER_VIEW, met.distance_px.shape[2]))
        J[..., CENTRE, :] = by_y
        J[..., LOG_RADIUS, :] = met.by_log_radius()
        J[..., LOG_ASPECT, :] = met.by_log_aspect()
        J[..., AXIS, :] = along_d[..., None, :] * (E_T @ met.d)
        J[..., AXIS, :] += along_y[..., None, :] * (E_T @ y[..., None])
        J[..., EDGE, :] = 1.0
        J[..., DEPTH, :] = 0.0
        J[..., TURN, :] = _cross(met.d, by_d) * self._sigmas[:3, None]
        J[..., SHIFT, :] = -by_y * self._sigmas[3:, None]
        return met.distance_px + hypotheses.edge_px[:, None, None], J

    def poles(
        self, hypotheses: Hypotheses, turned: np.ndarray, y: np.ndarray, E: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """What the calyxes say (S, V, 3), in deviations, and (S, V, 15, 3) derivatives.

        Two are the difference to a calyx in sight. The third is one-sided: where none is, it must
        not face the camera at a place where bare skin is in sight.
        """
        pixel, pixel_J = self._calyx_pixel(hypotheses, turned, y, E)
        off = np.empty((*pixel.shape[:2], 3))
        J = np.zeros((*pixel.shape[:2], SHARED + PER_VIEW, 3))
        off[..., :2] = (pixel - self._views.calyx_px) * self._views.calyx_inverse[:, None]
        J[..., :2] = np.swapaxes(pixel_J * self._views.calyx_inverse[:, None, None], -1, -2)
        a = hypotheses.axis[:, None]
        reach = np.exp(hypotheses.log_radius + hypotheses.log_aspect)[:, None, None]
        pole = y - reach * a
        distance = np.linalg.norm(pole, axis=-1, keepdims=True)
        toward = pole / distance
        facing = (toward * a).sum(axis=-1)
        excess = facing - self._config.hidden_facing
        is_wrong = (excess > 0.0) & ~self._views.has_calyx
        is_wrong[is_wrong] = self._is_on_skin(pixel, is_wrong)
        scale = is_wrong / self._config.hidden_sigma
        off[..., 2] = excess * scale
        by_axis = toward - reach * (a - facing[..., None] * toward) / distance
        J[..., AXIS, 2] = (by_axis @ E) * scale[..., None]
        return off, J

    def _is_on_skin(self, pixel: np.ndarray, asked: np.ndarray) -> np.ndarray:
        """Of pixels (S, V, 2), those where `asked` (S, V): whether bare skin is in sight there."""
        view = np.nonzero(asked)[1]
        near = np.abs(pixel[asked][:, None] - self._views.skin_px[view]).max(axis=-1).min(axis=-1)
        return np.asarray(near <= self._views.skin_reach_px[view])

    def _calyx_pixel(
        self, hypotheses: Hypotheses, turned: np.ndarray, y: np.ndarray, E: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Where each view shows the calyx (S, V, 2), and (S, V, 2, 15) derivatives."""
        a = hypotheses.axis[:, None]
        reach = (np.exp(hypotheses.log_radius + hypotheses.log_aspect) * hypotheses.depth)[:, None]
        pole = y - reach[..., None] * a
        rotation = turned @ self._views.rotation
        x = (pole[..., None, :] @ rotation)[..., 0, :]
        flat = x[..., :2] / x[..., 2:]
        by_pole = np.swapaxes(rotation, -1, -2)
        by_pole = (by_pole[..., :2, :] - flat[..., None] * by_pole[..., 2:, :]) / x[..., 2:, None]
        by_pole = by_pole * self._views.focal_px[:, :, None]
        outward = -(by_pole @ a[..., None])[..., 0] * reach[..., None]
        J = np.empty((*flat.shape, SHARED + PER_VIEW))
        J[..., CENTRE] = by_pole
        J[..., LOG_RADIUS] = J[..., LOG_ASPECT] = outward
        J[..., AXIS] = -reach[..., None, None] * (by_pole @ E[:, None])
        J[..., EDGE] = 0.0
        J[..., DEPTH] = outward / hypotheses.depth[:, None, None]
        turn = _cross(np.swapaxes(by_pole, -1, -2), pole[..., None])
        J[..., TURN] = np.swapaxes(turn, -1, -2) * self._sigmas[:3]
        J[..., SHIFT] = -by_pole * self._sigmas[3:]
        return flat * self._views.focal_px + self._views.principal_px, J

    def _with_priors(
        self, hypotheses: Hypotheses, cost: np.ndarray, matrix: np.ndarray, gradient: np.ndarray
    ) -> NormalEquations:
        """Adds what is known before the images, and parts the views' own parameters."""
        config, inverse = self._config, self._prior_inverse()
        off = np.zeros((len(cost), SHARED))
        off[:, LOG_RADIUS] = hypotheses.log_radius - np.log(config.radius_m)
        off[:, LOG_ASPECT] = hypotheses.log_aspect - np.log(config.aspect)
        off[:, EDGE], off[:, DEPTH] = hypotheses.edge_px, hypotheses.depth - 1.0
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

    def _prior_inverse(self) -> np.ndarray:
        """(9,) 1 / deviation of what is known of the shared parameters before the images."""
        config, inverse = self._config, np.zeros(SHARED)
        inverse[[LOG_RADIUS, LOG_ASPECT, EDGE, DEPTH]] = [
            1.0 / config.radius_sigma,
            1.0 / config.aspect_sigma,
            1.0 / config.edge_sigma_px,
            1.0 / config.depth_sigma,
        ]
        return inverse


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


def descend(
    model: OutlineModel, hypotheses: Hypotheses, scale_px: float, steps: int
) -> tuple[Hypotheses, NormalEquations]:
    """Moves all hypotheses by Levenberg-Marquardt steps; one that a step makes worse stays.

    A step so long that its cost is no number is such a one.
    """
    system = model.evaluate(hypotheses, scale_px)
    damping, is_done = np.full(len(system.cost), 1e-3), np.zeros(len(system.cost), bool)
    for _ in range(steps):
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            moved = hypotheses.moved(*_step(system, damping))
            after = model.evaluate(moved, scale_px)
        better = after.cost < system.cost
        hypotheses = chosen_of(better, moved, hypotheses)
        gain = np.where(better, system.cost - after.cost, 0.0)
        system = chosen_of(better, after, system)
        damping = np.where(better, damping * 0.3, damping * 10.0)
        is_done |= (better & (gain < _SMALL_GAIN)) | (damping > _STUCK)
        if is_done.all():
            break
    return hypotheses, system


def _step(system: NormalEquations, damping: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Steps (S, 9) and (S, V, 6): views eliminated first, as in bundle adjustment."""
    matrix, gradient, eliminated, rest = without_views(system)
    diagonal = np.einsum("sii->si", matrix)
    damped = matrix + np.eye(SHARED) * ((diagonal + 1e-9) * damping[:, None])[:, None, :]
    shared = -solved(damped, gradient[..., None])[..., 0]
    tilt = np.linalg.norm(shared[:, AXIS], axis=-1, keepdims=True)
    shared[:, AXIS] *= np.minimum(1.0, _LONGEST_TILT / np.maximum(tilt, 1e-12))
    return shared, -(eliminated @ shared[:, None, :, None])[..., 0] - rest
