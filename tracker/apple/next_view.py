"""Where to look from next: the camera pose after which the axis would be known best.

For every explanation that a fit holds, the picture from a candidate pose is predicted: outline,
calyx if it faces the camera, size in the image. Its derivatives give the information it would add,
errors of the camera's pose allowed for, and so the axis's covariance afterwards; how differently
the explanations would look from there says how far it would tell them apart.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from tracker.apple.attitude import axis_error_deg, tangent_basis, unit
from tracker.apple.hypotheses import AXIS, PER_VIEW, SHARED, Hypotheses, solved
from tracker.apple.outline_model import OutlineModel
from tracker.apple.outline_views import OutlineModelConfig
from tracker.apple.silhouette_fit import SilhouetteFit
from tracker.apple.spheroid import Spheroid, ellipse_of_cone
from tracker.apple.view import CameraPose, FruitStatus, FruitView, Sighting
from tracker.checks import require_count, require_positive, require_share

_WILD = 1e10
"""Trace of a view's matrix, in units of its pose's deviations, above which it means nothing."""
_LEAST_LIKELY = 700.0
"""Half a sum of squares of which the exponential is still a number."""


@dataclass(frozen=True)
class NextViewConfig:
    """What a picture is expected to show."""

    model: OutlineModelConfig = field(default_factory=OutlineModelConfig)
    calyx_facing: float = 0.35
    """Cosine between the calyx's normal and the direction to the camera above which it counts on
    being seen."""
    visible_share: float = 1.0
    """Share of the outline that leaves are expected to spare."""
    margin_px: float = 10.0
    """The fruit must stay this far from the image's border."""
    point_count: int = 32
    """Outline points of a predicted picture."""

    def __post_init__(self) -> None:
        require_positive(self, "margin_px", "visible_share")
        require_share(self, "visible_share")
        require_count(self, "point_count", least=8)


def predicted_sigmas_deg(
    fit: SilhouetteFit,
    candidates: Sequence[CameraPose],
    K: np.ndarray,
    image_size_px: tuple[int, int],
    config: NextViewConfig | None = None,
) -> np.ndarray:
    """(n,) root mean square deviation [deg] of the axis after one more view from each pose.

    Infinite where the fruit would not lie wholly in the image.

    Args:
        fit: What is known from the views so far.
        candidates: Poses that the arm can reach.
        K: (3, 3) intrinsics.
        image_size_px: Width and height.
        config: What a picture is expected to show.
    """
    config = config or NextViewConfig()
    return np.array([_sigma_deg(fit, pose, K, image_size_px, config) for pose in candidates])


def views_around(
    fruit_m: np.ndarray,
    toward: np.ndarray,
    distance_m: float,
    largest_rad: float,
    count: int,
    up: tuple[float, float, float] = (0.0, 0.0, 1.0),
) -> list[CameraPose]:
    """Poses that look at the fruit, spread evenly over a cap of a sphere about it.

    Args:
        fruit_m: (3,) its middle in the robot's frame.
        toward: (3,) from there towards the middle of the cap, such as the present camera.
        distance_m: Radius of the sphere.
        largest_rad: Angle between `toward` and the rim of the cap.
        count: Number of poses; the first is in the middle.
        up: (3,) what is up in the images.
    """
    if count < 1:
        raise ValueError(f"count must be 1 or greater, got {count}")
    middle = unit(np.asarray(toward, float))
    E = tangent_basis(middle)
    share = np.arange(count) / max(1, count - 1)
    polar = np.arccos(1.0 - share * (1.0 - math.cos(largest_rad)))
    turn = np.pi * (3.0 - math.sqrt(5.0)) * np.arange(count)
    aside = np.stack([np.cos(turn), np.sin(turn)], axis=-1) @ E.T
    directions = np.cos(polar)[:, None] * middle + np.sin(polar)[:, None] * aside
    return [looking_at(fruit_m, fruit_m + distance_m * d, up) for d in directions]


def looking_at(
    target_m: np.ndarray, position_m: np.ndarray, up: tuple[float, float, float] = (0.0, 0.0, 1.0)
) -> CameraPose:
    """A camera at `position_m` (3,) with the target (3,) in the middle of the image."""
    forward = unit(target_m - position_m)
    right = np.cross(forward, np.array(up))
    if np.linalg.norm(right) < 1e-6:
        right = tangent_basis(forward)[:, 0]
    right = unit(right)
    return CameraPose(np.stack([right, np.cross(forward, right), forward], axis=1), position_m)


def _sigma_deg(
    fit: SilhouetteFit,
    pose: CameraPose,
    K: np.ndarray,
    image_size_px: tuple[int, int],
    config: NextViewConfig,
) -> float:
    fruits = [hypothesis.fruit for hypothesis in fit.hypotheses]
    predicted = [_predicted(fruit, pose, K, image_size_px, config) for fruit in fruits]
    known = [sighting for sighting in predicted if sighting is not None]
    if len(known) < len(predicted):
        return math.inf
    together = _as_hypotheses(fruits)
    models = [OutlineModel([sighting], config.model) for sighting in known]
    total = 0.0
    for i, (explanation, model) in enumerate(zip(fit.hypotheses, models, strict=True)):
        added = model.information(together.take(np.array([i])))[0] * config.visible_share
        covariance = solved(explanation.information + added, np.eye(SHARED))[AXIS, AXIS]
        likeness = np.exp(-_misfit(model, together))
        others = np.array([other.probability for other in fit.hypotheses]) * likeness
        others[i] = explanation.probability
        apart = np.radians(axis_error_deg(together.axis, explanation.fruit.axis))
        between = float((others * apart**2).sum() / others.sum())
        total += explanation.probability * (float(np.trace(covariance)) + between)
    return math.degrees(math.sqrt(total))


def _misfit(model: OutlineModel, hypotheses: Hypotheses) -> np.ndarray:
    """(S,) half the sum of squares with which each hypothesis explains a picture, at best.

    The errors of the camera's pose are fitted, by one linear step.
    """
    system = model.evaluate(hypotheses, np.inf)
    # A hypothesis that a normal of the picture grazes has derivatives beyond all bounds, and the
    # picture is surely not its own.
    is_wild = ~(np.einsum("svii->s", system.view_matrix) < _WILD)
    pick = is_wild[:, None, None, None]
    matrix = np.where(pick, np.eye(PER_VIEW), system.view_matrix)
    step = solved(matrix, system.view_gradient[..., None])[..., 0]
    gain = 0.5 * (system.view_gradient * step).sum(axis=(1, 2))
    misfit = np.where(is_wild, _LEAST_LIKELY, system.cost - gain)
    return np.clip(misfit, 0.0, _LEAST_LIKELY)


def _predicted(
    fruit: Spheroid,
    pose: CameraPose,
    K: np.ndarray,
    image_size_px: tuple[int, int],
    config: NextViewConfig,
) -> Sighting | None:
    """The view of a fruit from a pose; None where it is not wholly in the image."""
    toward = pose.rotation[:, 2] @ (fruit.centre_m - pose.position_m)
    if toward <= 2.0 * fruit.radius_m * max(1.0, fruit.aspect):
        return None
    outline = fruit.outline_px(K, pose, config.point_count)
    limit = np.array(image_size_px) - 1.0 - config.margin_px
    if (outline < config.margin_px).any() or (outline > limit).any():
        return None
    centre, semi_axes, angle = ellipse_of_cone(fruit.cone(pose), K)
    is_seen = fruit.calyx_facing(pose) > config.calyx_facing
    calyx = fruit.calyx_px(K, pose) if is_seen else None
    view = FruitView(FruitStatus.FOUND, centre, semi_axes, angle, calyx, 1.0, outline)
    return Sighting(view, K, pose)


def _as_hypotheses(fruits: Sequence[Spheroid]) -> Hypotheses:
    count = len(fruits)
    return Hypotheses(
        centre_m=np.stack([fruit.centre_m for fruit in fruits]),
        axis=np.stack([fruit.axis for fruit in fruits]),
        log_radius=np.log([fruit.radius_m for fruit in fruits]),
        log_aspect=np.log([fruit.aspect for fruit in fruits]),
        edge_px=np.zeros(count),
        depth=np.ones(count),
        pose_error=np.zeros((count, 1, PER_VIEW)),
    )
