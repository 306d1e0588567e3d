"""The fruit that explains its outlines and calyxes in all views at once.

Each view's outline is the exact conic of a spheroid (`spheroid`), so points on any part of it will
do: leaves in front take points away and bend nothing. What single views cannot show, the tilt of
the axis along the line of sight, shows in how the outline's shape changes from view to view, beside
the aspect of this very fruit, which is fitted with it. Errors of the cameras' poses are fitted too,
each within its declared deviation.

The cost has several valleys, so Gauss-Newton steps start from axes all over the sphere, all at
once, while the loss narrows from tolerant to robust.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from tracker.apple.attitude import angle_between_deg, tangent_basis, unit
from tracker.apple.hypotheses import (
    AXIS,
    PER_VIEW,
    Hypotheses,
    NormalEquations,
    chosen_of,
    without_views,
)
from tracker.apple.outline_model import OutlineModel, descend
from tracker.apple.outline_views import OutlineModelConfig
from tracker.apple.spheroid import Spheroid, cone_of_ellipse, principal_cone
from tracker.apple.view import Sighting, found
from tracker.checks import require_count, require_positive

_EQUAL_COST = 1.0
"""Both signs of an axis explain the images equally well if their costs differ by less."""
_SAME_DEG = 4.0
"""Hypotheses with axes no further apart are one."""


@dataclass(frozen=True)
class SilhouetteFitConfig:
    """Starts and steps of the joint fit."""

    model: OutlineModelConfig = field(default_factory=OutlineModelConfig)
    start_count: int = 8
    """Axes over the whole sphere."""
    first_scale_px: float = 8.0
    """Outline points further off than this lose their pull in the first round."""
    last_scale_px: float = 0.7
    """The same in the last round."""
    round_count: int = 4
    """Rounds, from the first scale to the last."""
    steps: int = 3
    """Steps of all hypotheses a round."""
    search_point_count: int = 20
    """Outline points of a view in these rounds."""
    kept_count: int = 3
    """Hypotheses that are refined to the end, with all points."""
    last_steps: int = 20
    """Most steps of these."""
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """Where the stem points when the images leave open which end it is at: robot's frame."""

    def __post_init__(self) -> None:
        require_positive(self, "first_scale_px", "last_scale_px")
        require_count(self, "start_count", "round_count", "steps", "last_steps", "kept_count")


@dataclass(frozen=True, eq=False)
class AxisHypothesis:
    """One explanation of the images."""

    fruit: Spheroid
    probability: float
    """Probability among the explanations that were found."""
    axis_covariance: np.ndarray
    """(3, 3) [rad²] of small deviations of the axis in the robot's frame, 0 along it."""
    information: np.ndarray
    """(9, 9) of the parameters that all views share (`outline_model`)."""


@dataclass(frozen=True, eq=False)
class SilhouetteFit:
    """The best explanation, and what else the images allow."""

    hypotheses: tuple[AxisHypothesis, ...]
    """The explanations, the most probable first; an axis and its opposite are two only where the
    images distinguish them."""
    residual_px: float
    """Robust root mean square of the outline points' distances."""
    is_sign_seen: bool
    """Whether the images show which end has the calyx; else the stem is taken to be up."""

    @property
    def fruit(self) -> Spheroid:
        """The most probable one."""
        return self.hypotheses[0].fruit

    @property
    def axis(self) -> np.ndarray:
        """(3,) unit vector from calyx to stem, in the robot's frame."""
        return self.fruit.axis

    @property
    def axis_covariance(self) -> np.ndarray:
        """(3, 3) [rad²] of the axis, the other explanations included as lines without a sign."""
        total = np.zeros((3, 3))
        for hypothesis in self.hypotheses:
            other = hypothesis.fruit.axis
            apart = other * math.copysign(1.0, float(other @ self.axis)) - self.axis
            spread = hypothesis.axis_covariance + np.outer(apart, apart)
            total += hypothesis.probability * spread
        return total

    @property
    def axis_sigma_deg(self) -> float:
        """Root mean square deviation [deg] of the axis by its covariance."""
        return math.degrees(math.sqrt(float(np.trace(self.axis_covariance))))


def fit_silhouettes(
    sightings: Sequence[Sighting], config: SilhouetteFitConfig | None = None
) -> SilhouetteFit | None:
    """The fruit by all views, or None where none of them has one.

    Args:
        sightings: Views with their cameras; those without a fruit to use are left out.
        config: Starts and noise.
    """
    config = config or SilhouetteFitConfig()
    usable = found(sightings)
    if not usable:
        return None
    hypotheses = _searched(usable, config)
    model = OutlineModel(usable, config.model)
    hypotheses, system = descend(model, hypotheses, config.last_scale_px, config.last_steps)
    hypotheses, system, lead = _with_signs(model, hypotheses, system, config)
    return _answer(model, hypotheses, system, lead, config)


def _searched(sightings: Sequence[Sighting], config: SilhouetteFitConfig) -> Hypotheses:
    """The best few distinct explanations of some of the points."""
    count = min(config.search_point_count, config.model.point_count)
    model = OutlineModel(sightings, replace(config.model, point_count=count))
    hypotheses, cost = _starts(sightings, config), np.zeros(0)
    scales = np.geomspace(config.first_scale_px, config.last_scale_px, config.round_count)
    for scale in scales:
        hypotheses, system = descend(model, hypotheses, float(scale), config.steps)
        cost = system.cost
    return hypotheses.take(_distinct(hypotheses, cost, config.kept_count))


def _starts(sightings: Sequence[Sighting], config: SilhouetteFitConfig) -> Hypotheses:
    """Hypotheses with the place and size of the ellipses, and axes all over the sphere."""
    centre, radius = _triangulated(sightings, config.model)
    axes = _sphere(config.start_count)
    count = len(axes)
    return Hypotheses(
        centre_m=np.tile(centre, (count, 1)),
        axis=axes,
        log_radius=np.full(count, math.log(radius)),
        log_aspect=np.full(count, math.log(config.model.aspect)),
        edge_px=np.zeros(count),
        depth=np.ones(count),
        pose_error=np.zeros((count, len(sightings), PER_VIEW)),
    )


def _triangulated(
    sightings: Sequence[Sighting], config: OutlineModelConfig
) -> tuple[np.ndarray, float]:
    """Centre (3,) and radius [m]: least squares over rays, and weakly over the usual size.

    A cone with the wide half-angle θ puts a fruit of radius r at r / sin θ: with the camera at p,
    its ray e and the unknown c and r, e·(c - p) = r / sin θ and the components across e are zero.
    """
    rows: list[np.ndarray] = []
    right: list[np.ndarray] = []
    for sighting in sightings:
        view = sighting.view
        assert view.centre_px is not None and view.semi_axes_px is not None
        assert view.major_angle_rad is not None
        cone = cone_of_ellipse(view.centre_px, view.semi_axes_px, view.major_angle_rad, sighting.K)
        directions, half_angles = principal_cone(cone)
        axes = directions @ sighting.pose.rotation.T
        distance = config.radius_m / math.sin(half_angles[0])
        weights = np.array([1.0, 1.0, 0.3]) / distance
        size = np.array([0.0, 0.0, -1.0 / math.sin(half_angles[0])])
        rows.append(np.column_stack([axes, size]) * weights[:, None])
        right.append((axes @ sighting.pose.position_m) * weights)
    rows.append(np.array([[0.0, 0.0, 0.0, 0.03 / (config.radius_m * config.radius_sigma)]]))
    right.append(np.array([0.03 / config.radius_sigma]))
    solution = np.linalg.lstsq(np.concatenate(rows), np.concatenate(right), rcond=None)[0]
    radius = float(np.clip(solution[3], 0.3 * config.radius_m, 3.0 * config.radius_m))
    return solution[:3], radius


def _sphere(count: int) -> np.ndarray:
    """(count, 3) unit vectors, evenly spread: a Fibonacci lattice."""
    index = np.arange(count) + 0.5
    z = 1.0 - 2.0 * index / count
    turn = np.pi * (1.0 + math.sqrt(5.0)) * index
    flat = np.sqrt(1.0 - z**2)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=-1)


def _distinct(hypotheses: Hypotheses, cost: np.ndarray, count: int) -> np.ndarray:
    """Indices of the best hypotheses whose lines differ; the sign is looked at later."""
    kept: list[int] = []
    for index in np.argsort(cost, kind="stable"):
        others = hypotheses.axis[kept]
        apart = angle_between_deg(others, hypotheses.axis[index]) if kept else np.array([90.0])
        if (np.minimum(apart, 180.0 - apart) > _SAME_DEG).all():
            kept.append(int(index))
        if len(kept) == count:
            break
    return np.array(kept)


def _with_signs(
    model: OutlineModel,
    hypotheses: Hypotheses,
    system: NormalEquations,
    config: SilhouetteFitConfig,
) -> tuple[Hypotheses, NormalEquations, np.ndarray]:
    """Each line with the end at which the images, or else `up`, put the stem.

    Also by how much (S,) the costs of both ends differ.
    """
    flipped = replace(hypotheses, axis=-hypotheses.axis)
    turned, turned_system = descend(model, flipped, config.last_scale_px, 4)
    is_up = hypotheses.axis @ unit(np.array(config.up)) >= 0.0
    lead = turned_system.cost - system.cost
    stays = np.where(np.abs(lead) > _EQUAL_COST, lead > 0.0, is_up)
    lead = np.abs(lead)
    return chosen_of(stays, hypotheses, turned), chosen_of(stays, system, turned_system), lead


def _answer(
    model: OutlineModel,
    hypotheses: Hypotheses,
    system: NormalEquations,
    lead: np.ndarray,
    config: SilhouetteFitConfig,
) -> SilhouetteFit:
    kept = _distinct(hypotheses, system.cost, config.kept_count)
    hypotheses = hypotheses.take(kept)
    matrix = without_views(system)[0][kept]
    odds = np.exp(-np.minimum(system.cost[kept] - system.cost[kept[0]], 700.0))
    covariance = np.linalg.inv(matrix)[:, AXIS, AXIS]
    E = tangent_basis(hypotheses.axis)
    spread = E @ covariance @ np.swapaxes(E, -1, -2)
    explanations = tuple(
        AxisHypothesis(
            Spheroid(
                hypotheses.centre_m[i],
                hypotheses.axis[i],
                math.exp(hypotheses.log_radius[i]),
                math.exp(hypotheses.log_aspect[i]),
            ),
            float(odds[i] / odds.sum()),
            spread[i],
            matrix[i],
        )
        for i in range(len(kept))
    )
    residual_px = model.residual_px(hypotheses.take(np.array([0])))
    return SilhouetteFit(explanations, residual_px, bool(lead[kept[0]] > _EQUAL_COST))
