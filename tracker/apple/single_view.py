"""The fruit's axis from one image: the two methods of [Zhou2011], as printed and in perspective.

Method 1, for a hidden calyx, takes the axis perpendicular to the long axis of the region, in the
image plane; it holds for oblate fruit. Method 2 takes it from the offset between the calyx and the
middle of the region. Both take the picture for a parallel projection along the optical axis. The
perspective forms measure the cone of rays that touch the fruit instead: what [Zhou2011] reads off
the image plane, they read off the plane across the line of sight.
"""

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from tracker.apple.attitude import unit
from tracker.apple.spheroid import Spheroid, cone_of_ellipse, principal_cone
from tracker.apple.view import CameraPose, FruitView, Sighting
from tracker.checks import require_choice, require_positive
from tracker.geometry import rays_of

_AT_CAMERA = CameraPose(np.eye(3), np.zeros(3))
_ROUNDS = 4
"""Rounds in which method 2 corrects the place of the fruit for its shape."""


class Method(StrEnum):
    """What the axis was taken from."""

    INERTIA = "inertia"
    """Method 1: the long axis of the region."""
    OFFSET = "offset"
    """Method 2: where the calyx lies in the region."""


@dataclass(frozen=True)
class SingleViewConfig:
    """What is assumed about the fruit, and what the answers are worth."""

    form: str = "perspective"
    """`paper` for the formulas as printed, or `perspective`."""
    aspect: float = 0.9
    """Height divided by diameter: [Zhou2011] takes half the height L for known."""
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """Direction in the robot's frame towards which the stem of method 1 points."""
    in_plane_sigma_rad: float = 0.05
    """Deviation of method 1 in the plane across the line of sight."""
    tilt_sigma_rad: float = 0.35
    """Deviation of an axis from that plane, in which method 1 puts it."""
    offset_sigma_rad: float = 0.05
    """Deviation of method 2, in every direction."""

    def __post_init__(self) -> None:
        require_choice(self, "form", ("paper", "perspective"))
        require_positive(self, "aspect", "in_plane_sigma_rad", "tilt_sigma_rad", "offset_sigma_rad")


@dataclass(frozen=True, eq=False)
class AxisMeasurement:
    """The axis by one image."""

    method: Method
    axis: np.ndarray
    """(3,) unit vector from the calyx to the stem, in the robot's frame."""
    information: np.ndarray
    """(3, 3) [1/rad²] in the robot's frame, 0 along the axis: what the image says of each way in
    which the axis may be wrong. Method 1 sees little along the line of sight."""


def measure(sighting: Sighting, config: SingleViewConfig | None = None) -> AxisMeasurement | None:
    """The axis by the method that the image allows, or None where there is no fruit to use.

    Method 2 where the calyx is in sight, else method 1, as [Zhou2011] chooses by hand.
    """
    config = config or SingleViewConfig()
    view, R = sighting.view, sighting.pose.rotation
    if not view.is_found:
        return None
    ray = fruit_ray(view, sighting.K)
    up = R.T @ np.array(config.up)
    if view.calyx_px is None:
        method, axis = Method.INERTIA, inertia_axis(view, sighting.K, up, config.form)
        across = unit(np.cross(ray, axis))
        information = np.outer(across, across) / config.in_plane_sigma_rad**2
        information += np.outer(ray, ray) / config.tilt_sigma_rad**2
    else:
        method, axis = Method.OFFSET, offset_axis(view, sighting.K, config.aspect, config.form)
        information = (np.eye(3) - np.outer(axis, axis)) / config.offset_sigma_rad**2
    return AxisMeasurement(method, R @ axis, R @ information @ R.T)


def fruit_ray(view: FruitView, K: np.ndarray) -> np.ndarray:
    """(3,) unit ray, in the camera's frame, in the middle of the cone that touches the fruit."""
    return principal_cone(_cone(view, K))[0][2]


def inertia_axis(view: FruitView, K: np.ndarray, up: np.ndarray, form: str) -> np.ndarray:
    """(3,) axis in OpenCV's camera frame by method 1; the stem towards `up`.

    As printed, with α the angle of the long axis against the horizontal, counted up:
    a = (cos α, -sin α, 0) in the camera frame of [Zhou2011]; both lines of Eq. (1) are this one
    formula. In perspective the axis lies across the narrow side of the cone of rays: the cone is
    symmetric about the plane through the camera and the fruit's axis, so that plane is exact, and
    what remains of the method's assumption is that the axis is perpendicular to the line of sight.

    Args:
        view: With a fruit.
        K: (3, 3) intrinsics.
        up: (3,) in the camera's frame.
        form: `paper` or `perspective`.

    Source: [Zhou2011] Eq. (1).
    """
    if form == "paper":
        angle = _major_angle(view)
        axis = np.array([math.sin(angle), -math.cos(angle), 0.0])
    else:
        axis = principal_cone(_cone(view, K))[0][1]
    return axis if axis @ up >= 0.0 else -axis


def offset_axis(view: FruitView, K: np.ndarray, aspect: float, form: str) -> np.ndarray:
    """(3,) axis in OpenCV's camera frame by method 2.

    Eq. (2) of [Zhou2011] comes from the law of cosines; its numerators are 2 ΔX², 2 ΔY² and 2 ΔZ²,
    so that it says no more than a = (ΔX, ΔY, ΔZ) / L with ΔZ² = L² - ΔX² - ΔY², and that without
    its 0 / 0 where an offset is zero. An offset beyond L (noise near the outline) is cut to L. The
    signs, which the paper leaves open, follow from the calyx being in sight. L, half the fruit's
    height, is the aspect times the long semi-axis, which is the equator's radius in every view of
    an oblate fruit.

    In perspective the ray of the calyx meets the sphere on which the pole must lie. With the radius
    of the equator as the unit of length, a wide half-angle θ of the cone puts the fruit's middle at
    1 / sin θ along the ray in the middle of the cone, were it a ball; the spheroid's own cone then
    corrects that, in a few rounds.

    Args:
        view: With a fruit and its calyx.
        K: (3, 3) intrinsics.
        aspect: Height divided by diameter.
        form: `paper` or `perspective`.
    """
    if view.calyx_px is None or view.centre_px is None or view.semi_axes_px is None:
        raise ValueError("method 2 needs a found fruit with its calyx in sight")
    if form == "paper":
        offset = (view.centre_px - view.calyx_px) / (aspect * view.semi_axes_px[0])
        size = float(np.linalg.norm(offset))
        if size > 1.0:
            offset = offset / size
        return np.array([*offset, math.sqrt(max(0.0, 1.0 - min(size, 1.0) ** 2))])
    return _perspective_offset(_cone(view, K), unit(rays_of(view.calyx_px, K)), aspect)


def _perspective_offset(cone: np.ndarray, calyx_ray: np.ndarray, aspect: float) -> np.ndarray:
    """(3,) axis of a fruit that touches the cone and has its calyx on the ray (3,)."""
    directions, half_angles = principal_cone(cone)
    middle, sine = directions[2], math.sin(half_angles[0])
    centre, axis = middle / sine, middle
    for _ in range(_ROUNDS):
        along = float(calyx_ray @ centre)
        inside = aspect**2 - (float(centre @ centre) - along**2)
        axis = unit(centre - (along - math.sqrt(max(0.0, inside))) * calyx_ray)
        predicted = Spheroid(centre, axis, 1.0, aspect).cone(_AT_CAMERA)
        seen, seen_angles = principal_cone(predicted)
        distance = float(np.linalg.norm(centre)) * math.sin(seen_angles[0]) / sine
        centre = distance * unit(centre / np.linalg.norm(centre) + middle - seen[2])
    return axis


def _cone(view: FruitView, K: np.ndarray) -> np.ndarray:
    if view.centre_px is None or view.semi_axes_px is None:
        raise ValueError(f"no fruit to use in this view: {view.status}")
    return cone_of_ellipse(view.centre_px, view.semi_axes_px, _major_angle(view), K)


def _major_angle(view: FruitView) -> float:
    if view.major_angle_rad is None:
        raise ValueError(f"no fruit to use in this view: {view.status}")
    return view.major_angle_rad
