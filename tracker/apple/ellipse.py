"""An ellipse through outline points of which some lie on whatever hides the fruit.

Consensus of random samples first, then Gauss-Newton on the distances with a redescending weight.
What stands in front of a fruit only takes from its region, so a point outside the ellipse counts
against it more than one inside.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

_SAMPLES = 64
_SCORED = 100
"""Number of points by which samples are compared, evenly taken; the fit takes all points."""
_LEAST_RATIO = 0.70
"""An apple looks rounder than this from every side."""
_TRACE = 1e-9
"""Share of the unit matrix that is added to a matrix with terms of the size of 1."""
_LARGEST_STEP = np.array([20.0, 20.0, 0.2, 0.2, 0.5])
"""Largest change of the centre [px], log semi-axes and turn [rad] in one step."""


@dataclass(frozen=True, eq=False)
class FittedEllipse:
    """An ellipse in the image."""

    centre_px: np.ndarray
    """(2,) u, v."""
    semi_axes_px: np.ndarray
    """(2,) major, minor."""
    major_angle_rad: float
    """Direction of the major axis from +u towards +v, in [0, pi)."""
    covariance: np.ndarray
    """(5, 5) of u, v [px], log major, log minor, angle [rad]."""
    is_inlier: np.ndarray
    """(n,) bool, which of the points are on it."""
    parameter_rad: np.ndarray
    """(n,) eccentric angle of the ellipse's point that is nearest to each."""


@dataclass(frozen=True, eq=False)
class _Ellipse:
    """Centre, axes e1 and e2 (columns) and their lengths; e1 need not be the major one."""

    centre: np.ndarray
    axes: np.ndarray
    lengths: np.ndarray

    def signed_distances(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Distances (n,), positive outside, with directions and normals (2, n) of their feet.

        A direction is cosine and sine of the eccentric angle; normals are along the axes. To first
        order in the distance over the radius of curvature.
        """
        local = self.axes.T @ (points - self.centre).T
        direction = _unit(local * self.lengths[::-1, None])
        normal = _unit(direction * self.lengths[::-1, None])
        distance = ((local - direction * self.lengths[:, None]) * normal).sum(axis=0)
        return distance, direction, normal


def fit_ellipse(
    points_px: np.ndarray, is_trusted: np.ndarray, noise_px: float, tolerance_px: float
) -> FittedEllipse | None:
    """The ellipse that most of the points lie on, and none of the trusted ones far outside.

    Args:
        points_px: (n, 2) points of the outline.
        is_trusted: (n,) bool; the others may lie on the edge of something in front.
        noise_px: Standard deviation of a point's distance from the true outline.
        tolerance_px: Farthest that an inlier may be off.

    Returns: the ellipse; None where no ellipse of a fruit's shape has half of the points.
    """
    if len(points_px) < 8:
        return None
    middle = points_px.mean(axis=0)
    scale = float(np.sqrt(((points_px - middle) ** 2).sum(axis=1).mean()))
    if scale < 2.0:
        return None
    start = _consensus((points_px - middle) / scale, is_trusted, 1.5 * tolerance_px / scale)
    if start is None:
        return None
    ellipse = _Ellipse(middle + scale * start.centre, start.axes, scale * start.lengths)
    refined = _refine(ellipse, points_px, tolerance_px)
    if refined is None:
        return None
    ellipse, information = refined
    distance, (cosine, sine), _ = ellipse.signed_distances(points_px)
    angle = np.arctan2(sine, cosine)
    is_inlier = np.abs(distance) < tolerance_px
    if is_inlier.sum() < 8 or min(ellipse.lengths) < _LEAST_RATIO * max(ellipse.lengths):
        return None
    return _ordered(ellipse, noise_px**2 * np.linalg.pinv(information), is_inlier, angle)


def _consensus(points: np.ndarray, is_trusted: np.ndarray, tolerance: float) -> _Ellipse | None:
    """The best of many ellipses through five points each."""
    chosen = points[(_uniform() * len(points)).astype(int)]
    every = max(1, len(points) // _SCORED)
    points, is_trusted = points[::every], is_trusted[::every]
    conics = _conics_through(chosen)
    centres, shapes, is_valid = _shapes(conics)
    # The algebraic distance over its gradient, for all ellipses and points at once.
    x, y = points[:, 0] - centres[:, :1], points[:, 1] - centres[:, 1:]
    a, b, c = shapes[:, 0, 0, None], shapes[:, 0, 1, None], shapes[:, 1, 1, None]
    level = np.sqrt(np.maximum(a * x * x + 2 * b * x * y + c * y * y, 1e-12))
    distance = (level - 1.0) * np.sqrt(x * x + y * y) / level
    inliers = np.abs(distance) < tolerance
    weight = np.where(is_trusted, 2.0, 1.0)
    score = inliers @ weight - (distance >= tolerance) @ weight
    score = np.where(is_valid, score, -np.inf)
    index = int(np.argmax(score))
    if not (np.isfinite(score[index]) and score[index] > 0.2 * weight.sum()):
        return None
    values, vectors = np.linalg.eigh(shapes[index])
    return _Ellipse(centres[index], vectors, 1.0 / np.sqrt(values))


@cache
def _uniform() -> np.ndarray:
    """(samples, 5) numbers from 0 to 1, a stratum each: the same choice for every image."""
    rng = np.random.default_rng(0)
    strata = (np.arange(5) + rng.uniform(0.0, 1.0, (_SAMPLES, 5))) / 5.0
    return (strata + rng.uniform(0.0, 1.0, (_SAMPLES, 1))) % 1.0


def _conics_through(points: np.ndarray) -> np.ndarray:
    """Conics `a xx + b xy + c yy + d x + e y = 1` (m, 5) through five points each (m, 5, 2).

    The origin, which is the middle of the outline, lies in every ellipse that counts, so that the
    right side may be 1. A trace of the unit matrix keeps equal points from being singular.
    """
    x, y = points[..., 0], points[..., 1]
    rows = np.stack([x * x, x * y, y * y, x, y], axis=-1) + _TRACE * np.eye(5)
    return np.linalg.solve(rows, np.ones((len(points), 5, 1)))[..., 0]


def _shapes(conics: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Centres (m, 2), forms S (m, 2, 2) with `(p - c)' S (p - c) = 1`, and which are fruit-like."""
    a, b, c, d, e = conics.T
    determinant = 4.0 * a * c - b * b
    is_ellipse = determinant > 1e-9
    safe = np.where(is_ellipse, determinant, 1.0)
    centre = np.stack([(b * e - 2 * c * d) / safe, (b * d - 2 * a * e) / safe], axis=1)
    level = 1.0 - 0.5 * (d * centre[:, 0] + e * centre[:, 1])
    level = np.where(np.abs(level) > 1e-12, level, 1.0)
    shape = np.stack([np.stack([a, 0.5 * b], -1), np.stack([0.5 * b, c], -1)], -2)
    shape = shape / level[:, None, None]
    trace, det = shape[:, 0, 0] + shape[:, 1, 1], safe / 4.0 / level**2
    spread = np.sqrt(np.maximum(trace**2 / 4.0 - det, 0.0))
    small, large = trace / 2.0 - spread, trace / 2.0 + spread
    is_valid = is_ellipse & (small > 1e-3) & (small > _LEAST_RATIO**2 * large) & (large < 100.0)
    return centre, shape, is_valid


def _refine(
    ellipse: _Ellipse, points: np.ndarray, tolerance_px: float
) -> tuple[_Ellipse, np.ndarray] | None:
    """Gauss-Newton with Tukey's weights; the ellipse and the (5, 5) information of unit noise.

    Parameters: centre, logarithms of the two lengths, and the turn of the axes.
    """
    information = np.eye(5)
    for reach in (3.0, 2.0, 1.5, 1.0, 1.0, 1.0):
        distance, direction, normal = ellipse.signed_distances(points)
        weight = np.maximum(1.0 - (distance / (1.5 * reach * tolerance_px)) ** 2, 0.0) ** 2
        if np.count_nonzero(weight) < 8:
            return None
        jacobian = _jacobian(ellipse, direction, normal)
        information = (jacobian * weight) @ jacobian.T
        damping = 1e-6 * np.trace(information) / 5.0
        gradient = jacobian @ (weight * distance)
        step = np.asarray(np.linalg.solve(information + damping * np.eye(5), gradient), float)
        step = np.clip(step, -_LARGEST_STEP, _LARGEST_STEP)
        c, s = np.cos(step[4]), np.sin(step[4])
        ellipse = _Ellipse(
            ellipse.centre + step[:2],
            ellipse.axes @ np.array([[c, -s], [s, c]]),
            ellipse.lengths * np.exp(step[2:4]),
        )
    return ellipse, information


def _jacobian(ellipse: _Ellipse, direction: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """(5, n) how far the ellipse moves outwards at the feet, by parameter."""
    foot = direction * ellipse.lengths[:, None]
    turn = foot[0] * normal[1] - foot[1] * normal[0]
    return np.concatenate([ellipse.axes @ normal, foot * normal, turn[None]])


def _ordered(
    ellipse: _Ellipse, covariance: np.ndarray, is_inlier: np.ndarray, angle: np.ndarray
) -> FittedEllipse:
    """The same with the major axis first and its angle in [0, pi)."""
    axes, lengths = ellipse.axes, ellipse.lengths
    if lengths[0] < lengths[1]:
        order = [0, 1, 3, 2, 4]
        axes = np.column_stack([axes[:, 1], -axes[:, 0]])
        lengths, covariance, angle = (
            lengths[::-1],
            covariance[np.ix_(order, order)],
            angle - np.pi / 2,
        )
    # The turn of the axes is one in the image where they are right-handed, else the opposite.
    if np.linalg.det(axes) < 0.0:
        axes = axes * [1.0, -1.0]
        angle, flip = -angle, np.diag([1.0, 1.0, 1.0, 1.0, -1.0])
        covariance = flip @ covariance @ flip
    return FittedEllipse(
        centre_px=ellipse.centre,
        semi_axes_px=np.ascontiguousarray(lengths),
        major_angle_rad=_half_turn(float(np.arctan2(axes[1, 0], axes[0, 0]))),
        covariance=0.5 * (covariance + covariance.T),
        is_inlier=is_inlier,
        parameter_rad=angle,
    )


def _unit(vectors: np.ndarray) -> np.ndarray:
    """Columns (2, n) of length 1; (1, 0) for one that has no direction."""
    length = np.sqrt((vectors**2).sum(axis=0))
    if length.all():
        return vectors / length
    return np.where(length > 0.0, vectors / np.where(length > 0.0, length, 1.0), [[1.0], [0.0]])


def _half_turn(angle_rad: float) -> float:
    """The same direction of a line in [0, pi)."""
    turned = angle_rad % np.pi
    return 0.0 if turned >= np.pi else float(turned)
