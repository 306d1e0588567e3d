"""The views of one fruit as arrays: rays of outline points, calyxes, and where bare skin is."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tracker.apple.view import FruitView, Sighting
from tracker.checks import require_count, require_positive
from tracker.geometry import rays_of

_ELLIPSE_POINTS = 64
"""Number of points taken from the ellipse of a view without outline points."""
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


class OutlineViews:
    """V views; n outline points of each, those that a view lacks with the weight 0."""

    def __init__(self, sightings: Sequence[Sighting], config: OutlineModelConfig) -> None:
        self.rotation = np.stack([s.pose.rotation for s in sightings])
        """(V, 3, 3) camera -> robot."""
        self.position_m = np.stack([s.pose.position_m for s in sightings])
        """(V, 3)"""
        self.focal_px = np.stack([np.diag(s.K)[:2] for s in sightings])
        """(V, 2)"""
        self.principal_px = np.stack([s.K[:2, 2] for s in sightings])
        """(V, 2)"""
        self._set_outlines(sightings, config)
        self._set_calyxes([s.view for s in sightings], config)

    def _set_outlines(self, sightings: Sequence[Sighting], config: OutlineModelConfig) -> None:
        thinned = [_thinned(_outline_points(s.view), config.point_count) for s in sightings]
        shape = (len(sightings), 1, max(map(len, thinned)))
        self.rays = np.tile([[0.0], [0.0], [1.0]], shape)
        """(V, 3, n) of the outline points, in the robot's frame, of depth 1."""
        self.outward = np.tile([[1.0], [0.0], [0.0]], shape)
        """(V, 3, n) by how much a ray changes one pixel along the outline's normal."""
        self.weight = np.zeros(shape[::2])
        """(V, n) 1 / variance [1/px²]; less for points so close that they share their noise."""
        for i, (sighting, points) in enumerate(zip(sightings, thinned, strict=True)):
            n, R = len(points), sighting.pose.rotation
            slopes = _normals(sighting.view, points) / self.focal_px[i]
            self.rays[i, :, :n] = R @ rays_of(points, sighting.K).T
            self.outward[i, :, :n] = R[:, :2] @ slopes.T
            spacing = _arc_length_px(sighting.view) / max(1, n)
            independent = min(1.0, spacing / config.contour_correlation_px)
            self.weight[i, :n] = independent / config.contour_sigma_px**2

    def _set_calyxes(self, views: Sequence[FruitView], config: OutlineModelConfig) -> None:
        sizes = np.array([_ellipse(view)[1][0] for view in views])
        self.has_calyx = np.array([view.calyx_px is not None for view in views])
        """(V,)"""
        self.calyx_px = np.array([np.zeros(2) if (c := v.calyx_px) is None else c for v in views])
        """(V, 2)"""
        self.calyx_inverse = self.has_calyx / (config.calyx_sigma * sizes)
        """(V,) 1 / deviation [1/px], 0 without a calyx."""
        thinned = [_thinned(view.skin_px, config.skin_count) for view in views]
        self.skin_px = np.full((len(views), max(1, *map(len, thinned)), 2), np.inf)
        """(V, m, 2) where bare skin is in sight."""
        self.skin_reach_px = np.ones(len(views))
        """(V,) what is no further from such a point is bare, too."""
        for i, (view, points) in enumerate(zip(views, thinned, strict=True)):
            self.skin_px[i, : len(points)] = points
            if len(points):
                coarser = math.sqrt(len(view.skin_px) / len(points))
                self.skin_reach_px[i] = max(1.0, view.skin_step_px * coarser)
            elif view.arc_fraction >= _WHOLE:
                self.skin_px[i, 0], self.skin_reach_px[i] = _ellipse(view)[0], sizes[i]


def _ellipse(view: FruitView) -> tuple[np.ndarray, np.ndarray, float]:
    """Centre, semi-axes and angle of the major axis of a view with a fruit."""
    if view.centre_px is None or view.semi_axes_px is None or view.major_angle_rad is None:
        raise ValueError(f"no fruit to use in this view: {view.status}")
    return view.centre_px, view.semi_axes_px, view.major_angle_rad


def _outline_points(view: FruitView) -> np.ndarray:
    """(n, 2) the points that were found, or the ellipse's where a view has none."""
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
    """Returns at most so many of the points, evenly chosen."""
    if len(points) <= count:
        return points
    return points[np.linspace(0, len(points) - 1, count).round().astype(int)]
