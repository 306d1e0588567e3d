"""From an image to what it shows of the fruit: by colour, with OpenCV.

The fruit is red, leaves are green, calyx and stem are brown. Where a leaf hides a part, the border
of the red region is the leaf's, not the fruit's. Leaves bulge outwards, so that their border cuts
into the fruit: points that are not on the convex hull of the region are dropped, points beside a
leaf are trusted less, and the ellipse keeps those that agree with the others.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from tracker.apple.ellipse import FittedEllipse, fit_ellipse
from tracker.apple.view import FruitStatus, FruitView
from tracker.checks import require_positive, require_share

_BINS = 36
"""Sectors of the ellipse in which outline points are counted."""


@dataclass(frozen=True)
class SegmentationConfig:
    """Colours and sizes that separate a fruit from what is around it."""

    red_ratio: float = 1.65
    """Skin has so much more red than green or blue."""
    red_margin_levels: float = 6.0
    """Grey levels that skin must have on top of that ratio."""
    green_ratio: float = 1.25
    """A leaf has so much more green than red or blue."""
    least_area_px: float = 150.0
    """A smaller region is no fruit."""
    piece_share: float = 0.04
    """A region of at least this share of the largest may be a piece of the same fruit."""
    second_share: float = 0.30
    """A region apart of at least this share of the largest is a second fruit."""
    notch_share: float = 0.08
    """Where so much of a contour that no ellipse fits runs through notches in which there is no
    leaf, there are two fruits."""
    stem_share: float = 0.12
    """What is narrower than this share of the fruit is no part of it."""
    noise_px: float = 0.35
    """Deviation of an outline point from the true outline."""
    tolerance_px: float = 1.5
    """Farthest that a point may be from the ellipse and count."""
    least_arc: float = 0.20
    """With less of its outline in sight, a fruit is covered."""
    calyx_area: tuple[float, float] = (0.0015, 0.10)
    """Smallest and largest area of a calyx, as shares of the ellipse."""
    calyx_darkness: float = 0.80
    """A calyx is darker than this share of the skin's median red."""

    def __post_init__(self) -> None:
        require_positive(self, "red_ratio", "green_ratio", "least_area_px", "noise_px")
        require_positive(self, "tolerance_px", "red_margin_levels")
        for name in (
            "piece_share",
            "second_share",
            "notch_share",
            "stem_share",
            "least_arc",
            "calyx_darkness",
        ):
            require_share(self, name)
        if not 0.0 < self.calyx_area[0] < self.calyx_area[1] <= 1.0:
            raise ValueError(f"calyx_area must be 0 < low < high <= 1, got {self.calyx_area!r}")


@dataclass(frozen=True, eq=False)
class _Scene:
    """Masks of the part of the image around the fruit, by colour: (h, w) uint8, 255 for yes."""

    left: int
    top: int
    red: np.ndarray
    """The pieces of the fruit, holes not filled, stem removed."""
    filled: np.ndarray
    """The pieces with their holes."""
    leaf: np.ndarray
    brown: np.ndarray

    @property
    def origin(self) -> np.ndarray:
        return np.array([self.left, self.top], float)


def segment(rgb: np.ndarray, config: SegmentationConfig | None = None) -> FruitView:
    """What the image shows of the fruit.

    Args:
        rgb: (h, w, 3) uint8 colours.
        config: Colours and sizes; the defaults if None.
    """
    if rgb.ndim != 3 or rgb.shape[2] != 3 or rgb.dtype != np.uint8:
        raise ValueError(f"rgb must be (h, w, 3) uint8, got {rgb.shape} {rgb.dtype}")
    config = config or SegmentationConfig()
    red = _red_pixels(rgb, config)
    return _describe(rgb, red, config)


def view_of_masks(
    rgb: np.ndarray,
    is_skin: np.ndarray,
    is_calyx: np.ndarray,
    config: SegmentationConfig | None = None,
) -> FruitView:
    """The same from masks (h, w) bool of skin and calyx that somebody else has made."""
    config = config or SegmentationConfig()
    skin, calyx = (np.where(mask, 255, 0).astype(np.uint8) for mask in (is_skin, is_calyx))
    return _describe(rgb, skin, config, calyx)


def _describe(
    rgb: np.ndarray,
    red: np.ndarray,
    config: SegmentationConfig,
    calyx_mask: np.ndarray | None = None,
) -> FruitView:
    pieces = _pieces(red, config)
    if not pieces:
        return FruitView(FruitStatus.NO_FRUIT)
    if _touches_border(pieces, red.shape):
        return FruitView(FruitStatus.CUT_BY_BORDER)
    scene = _around(rgb, red, pieces, config)
    if calyx_mask is not None:
        rows, columns = scene.brown.shape
        window = calyx_mask[scene.top : scene.top + rows, scene.left : scene.left + columns]
        scene = replace(scene, brown=window)
    points, is_trusted = _outline(scene)
    ellipse = fit_ellipse(points, is_trusted, config.noise_px, config.tolerance_px)
    if ellipse is None:
        is_two = _bare_notch_share(scene) > config.notch_share
        return FruitView(FruitStatus.TWO_FRUITS if is_two else FruitStatus.COVERED)
    if _has_second(scene, ellipse, config):
        return FruitView(FruitStatus.TWO_FRUITS)
    arc = _arc_fraction(ellipse)
    if arc < config.least_arc:
        return FruitView(FruitStatus.COVERED)
    calyx, is_outside = _calyx(scene, ellipse, config)
    if is_outside:
        return FruitView(FruitStatus.CALYX_OUTSIDE)
    skin, step = _skin(scene, ellipse)
    return FruitView(
        FruitStatus.FOUND,
        centre_px=ellipse.centre_px + scene.origin,
        semi_axes_px=ellipse.semi_axes_px,
        major_angle_rad=ellipse.major_angle_rad,
        calyx_px=None if calyx is None else calyx + scene.origin,
        arc_fraction=arc,
        contour_px=points[ellipse.is_inlier] + scene.origin,
        skin_px=skin + scene.origin,
        skin_step_px=step,
        ellipse_covariance=ellipse.covariance,
    )


def _red_pixels(rgb: np.ndarray, config: SegmentationConfig) -> np.ndarray:
    """(h, w) uint8, 255 where the colour is that of the skin."""
    r, g, b = cv2.split(rgb)
    other = cv2.max(g, b)
    excess = cv2.addWeighted(r, 1.0, other, -config.red_ratio, -config.red_margin_levels)
    return cv2.threshold(excess, 0, 255, cv2.THRESH_BINARY)[1]


def _pieces(red: np.ndarray, config: SegmentationConfig) -> list[np.ndarray]:
    """Outer contours (n, 1, 2) of the regions that may belong to a fruit, the largest first."""
    contours, _ = cv2.findContours(red, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    sized = sorted(((cv2.contourArea(c), i) for i, c in enumerate(contours)), reverse=True)
    if not sized or sized[0][0] < config.least_area_px:
        return []
    least = max(config.piece_share * sized[0][0], 0.1 * config.least_area_px)
    return [contours[i] for area, i in sized if area >= least]


def _touches_border(pieces: list[np.ndarray], shape: tuple[int, ...]) -> bool:
    height, width = shape[:2]
    for piece in pieces:
        x, y, w, h = cv2.boundingRect(piece)
        if x <= 0 or y <= 0 or x + w >= width or y + h >= height:
            return True
    return False


def _around(
    rgb: np.ndarray, red: np.ndarray, pieces: list[np.ndarray], config: SegmentationConfig
) -> _Scene:
    """The window around the pieces with a margin, and its pixels by colour."""
    x, y, w, h = cv2.boundingRect(np.concatenate(pieces))
    margin = 6 + max(w, h) // 8
    height, width = red.shape
    left, top = max(x - margin, 0), max(y - margin, 0)
    right, bottom = min(x + w + margin, width), min(y + h + margin, height)
    filled = np.zeros((bottom - top, right - left), np.uint8)
    cv2.drawContours(filled, pieces, -1, 255, cv2.FILLED, offset=(-left, -top))
    filled = _without_stem(filled, config)
    r, g, b = cv2.split(rgb[top:bottom, left:right])
    excess = cv2.addWeighted(g, 1.0, cv2.max(r, b), -config.green_ratio, -3.0)
    leaf = cv2.threshold(excess, 0, 255, cv2.THRESH_BINARY)[1]
    inside = cv2.bitwise_and(red[top:bottom, left:right], filled)
    skin_level = _median_level(r, inside) if inside.any() else 255.0
    dark = cv2.threshold(r, config.calyx_darkness * skin_level, 255, cv2.THRESH_BINARY_INV)[1]
    reddish = cv2.threshold(cv2.addWeighted(r, 1.0, b, -1.15, 0.0), 0, 255, cv2.THRESH_BINARY)[1]
    brown = cv2.bitwise_and(cv2.bitwise_and(dark, reddish), cv2.bitwise_not(leaf))
    brown = cv2.bitwise_and(brown, cv2.bitwise_not(red[top:bottom, left:right]))
    return _Scene(left, top, inside, filled, leaf, brown)


def _median_level(channel: np.ndarray, mask: np.ndarray) -> float:
    """Median grey level under the mask, from its histogram."""
    counts: np.ndarray = np.array(cv2.calcHist([channel], [0], mask, [256], [0, 256]))
    return float(np.searchsorted(counts.cumsum(), 0.5 * float(counts.sum())))


def _without_stem(filled: np.ndarray, config: SegmentationConfig) -> np.ndarray:
    """The region without what is narrow, opened in a small copy; its outline stays as it is."""
    radius = np.sqrt(cv2.countNonZero(filled) / np.pi)
    reach = config.stem_share * radius
    shrink = max(1, int(reach / 2.0))
    small = cv2.resize(filled, None, fx=1 / shrink, fy=1 / shrink, interpolation=cv2.INTER_AREA)
    small = cv2.threshold(small, 127, 255, cv2.THRESH_BINARY)[1]
    half = max(1, round(reach / shrink))
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * half + 1, 2 * half + 1))
    opened = cv2.dilate(cv2.morphologyEx(small, cv2.MORPH_OPEN, disc), np.ones((3, 3), np.uint8))
    size = filled.shape[1], filled.shape[0]
    near = cv2.resize(opened, size, interpolation=cv2.INTER_NEAREST)
    kept = cv2.bitwise_and(filled, near)
    return kept if cv2.countNonZero(kept) else filled


def _outline(scene: _Scene) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 2) on the edge of the region's hull, and which of them are not beside a leaf.

    A contour runs through the centres of the outermost pixels of the region. The edge is half a
    pixel farther out along the image axis that is nearer to its normal.
    """
    contour, hull = _contour(scene)
    if not len(contour):
        return np.empty((0, 2)), np.empty(0, bool)
    points = contour[~_is_off_hull(scene, contour, hull, 1)].astype(float)
    moments = cv2.moments(hull)
    middle = np.array([moments["m10"], moments["m01"]]) / max(moments["m00"], 1e-9)
    outwards = points - middle
    outwards /= np.maximum(np.linalg.norm(outwards, axis=1, keepdims=True), 1e-9)
    is_trusted = ~_is_beside(scene, points + 2.5 * outwards)
    points += 0.5 * np.abs(outwards).max(axis=1, keepdims=True) * outwards
    return points, is_trusted


def _bare_notch_share(scene: _Scene) -> float:
    """Share of the contour that is deep inside its hull, and nowhere near a leaf or a stem."""
    contour, hull = _contour(scene)
    if not len(contour):
        return 0.0
    depth = max(3, round(0.05 * np.sqrt(cv2.contourArea(hull))))
    deep = contour[_is_off_hull(scene, contour, hull, depth)]
    near = np.concatenate([deep + step for step in ((3, 0), (-3, 0), (0, 3), (0, -3))])
    is_beside = _is_beside(scene, near.astype(float)).reshape(4, -1).any(axis=0)
    return float(np.count_nonzero(~is_beside)) / len(contour)


def _contour(scene: _Scene) -> tuple[np.ndarray, np.ndarray]:
    """Pixels (n, 2) of the outer contours of all pieces, and the hull (m, 1, 2) of them all."""
    contours, _ = cv2.findContours(scene.filled, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not contours:
        return np.empty((0, 2), np.int32), np.empty((0, 1, 2), np.int32)
    contour = np.concatenate(contours)
    return contour[:, 0], cv2.convexHull(contour)


def _is_off_hull(scene: _Scene, contour: np.ndarray, hull: np.ndarray, depth_px: int) -> np.ndarray:
    """(n,) bool, which pixels are so far inside the hull."""
    inner = np.zeros_like(scene.filled)
    cv2.fillConvexPoly(inner, hull, 255)
    size = 2 * depth_px + 1
    inner = np.asarray(cv2.erode(inner, np.ones((size, size), np.uint8), borderValue=0))
    return inner[contour[:, 1], contour[:, 0]] > 0


def _is_beside(scene: _Scene, points: np.ndarray) -> np.ndarray:
    """(n,) bool, which points lie on a leaf or on something brown."""
    height, width = scene.leaf.shape
    column, row = np.clip(np.rint(points).astype(int), 0, np.array([width - 1, height - 1])).T
    in_front = np.logical_or(scene.leaf > 0, scene.brown > 0)
    return np.asarray(in_front[row, column])


def _has_second(scene: _Scene, ellipse: FittedEllipse, config: SegmentationConfig) -> bool:
    """Whether much of the region lies outside the ellipse."""
    outside = cv2.countNonZero(
        cv2.bitwise_and(scene.filled, cv2.bitwise_not(_disc(scene, ellipse, 1.1)))
    )
    inside = cv2.countNonZero(scene.filled) - outside
    return outside > config.second_share * max(inside, 1)


def _disc(scene: _Scene, ellipse: FittedEllipse, scale: float) -> np.ndarray:
    """The inside of the ellipse, scaled about its centre, in the scene's window."""
    disc = np.zeros_like(scene.filled)
    axes = tuple(max(1, round(float(a) * scale * 16)) for a in ellipse.semi_axes_px)
    centre = tuple(round(float(c) * 16) for c in ellipse.centre_px)
    degrees = float(np.degrees(ellipse.major_angle_rad))
    cv2.ellipse(disc, centre, axes, degrees, 0.0, 360.0, 255, cv2.FILLED, cv2.LINE_8, 4)
    return disc


def _arc_fraction(ellipse: FittedEllipse) -> float:
    turns = ellipse.parameter_rad[ellipse.is_inlier] / (2.0 * np.pi) % 1.0
    return len(np.unique((turns * _BINS).astype(int) % _BINS)) / _BINS


def _calyx(
    scene: _Scene, ellipse: FittedEllipse, config: SegmentationConfig
) -> tuple[np.ndarray | None, bool]:
    """Centroid (2,) of the calyx in the window, None for none; and whether one is outside.

    A brown spot that leaves the fruit is a stem or a twig; one beside a leaf is cut by it, and its
    centroid is not that of the calyx.
    """
    count, labels, stats, centroids = cv2.connectedComponentsWithStats(scene.brown)
    labels = np.asarray(labels)
    area_px = np.pi * float(np.prod(ellipse.semi_axes_px))
    disc, hull = _disc(scene, ellipse, 1.02), scene.filled
    near_leaf: np.ndarray = np.array(cv2.dilate(scene.leaf, np.ones((5, 5), np.uint8)))
    best, best_area, is_outside = None, 0.0, False
    for label in range(1, count):
        area = float(stats[label, cv2.CC_STAT_AREA])
        if not config.calyx_area[0] * area_px <= area <= config.calyx_area[1] * area_px:
            continue
        left, top, width, height = stats[label, : cv2.CC_STAT_AREA]
        box = slice(top, top + height), slice(left, left + width)
        spot = labels[box] == label
        in_disc = disc[box][spot]
        if np.count_nonzero(in_disc) < 0.95 * area:
            beyond = (hull[box][spot] > 0) & (in_disc == 0)
            is_outside = is_outside or bool(np.count_nonzero(beyond) > 0.9 * area)
            continue
        if np.count_nonzero(near_leaf[box][spot]) > 0.15 * area:
            continue
        if area > best_area:
            best, best_area = centroids[label], area
    return best, is_outside and best is None


def _skin(scene: _Scene, ellipse: FittedEllipse) -> tuple[np.ndarray, float]:
    """Pixels (m, 2) of a sparse grid at which skin is in sight, and their spacing."""
    step = max(3, int(ellipse.semi_axes_px[0] / 12.0))
    # Noise reddens single pixels of a calyx.
    solid = cv2.erode(scene.red, np.ones((3, 3), np.uint8))
    is_skin = np.asarray(cv2.bitwise_and(solid, _disc(scene, ellipse, 0.97)))
    rows, columns = np.nonzero(is_skin[step // 2 :: step, step // 2 :: step])
    return np.column_stack([columns, rows]) * float(step) + step // 2, float(step)
