"""Attitude of a fruit: a unit vector from calyx to stem, and the angles of [Zhou2011].

[Zhou2011] describes an axis by its angles to the three axes of a frame. They are one number too
many (their cosines have squares that sum to one), so here an attitude is the unit vector, and the
angles are made for tables alone. The camera of [Zhou2011] has x up, y to the right and z forward:
the only reading in which Eqs. (1) and (2) and both tables agree. OpenCV's camera has x right and y
down.
"""

import numpy as np

from tracker.geometry import rotation_about_fixed_axes

PAPER_FROM_OPENCV = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""(3, 3) camera of OpenCV -> camera of [Zhou2011]; proper rotation, so handedness is kept."""
PAPER_FROM_OPENCV.setflags(write=False)

_UNIT_TOLERANCE = 0.02
"""Whole degrees, as published, leave the squared cosines up to this far from one."""


def unit(vector: np.ndarray) -> np.ndarray:
    """(..., 3) vectors of length one; ValueError for one that has no direction."""
    length = np.linalg.norm(vector, axis=-1, keepdims=True)
    if not (np.isfinite(length) & (length > 0.0)).all():
        raise ValueError(f"a direction must be finite and not zero, got {np.asarray(vector)}")
    return vector / length


def require_unit(axis: np.ndarray, tolerance: float = 1e-6) -> None:
    """ValueError unless `axis` (..., 3) is finite and of length one."""
    if axis.shape[-1:] != (3,) or not np.isfinite(axis).all():
        raise ValueError(f"an axis must have three finite components, got {axis.tolist()}")
    lengths = np.linalg.norm(axis, axis=-1)
    if (np.abs(lengths - 1.0) > tolerance).any():
        raise ValueError(f"an axis must have length 1, got length {np.round(lengths, 6).tolist()}")


def angles_deg(axis: np.ndarray) -> np.ndarray:
    """(..., 3) angles [deg] between axes (..., 3) of length one and the axes of the frame.

    Source: [Zhou2011], the attitude vector of section 1.
    """
    require_unit(axis)
    return np.degrees(np.arccos(np.clip(axis, -1.0, 1.0)))


def axis_of_angles(angles: np.ndarray) -> np.ndarray:
    """(..., 3) unit vectors with angles (..., 3) [deg] to the axes of the frame.

    Rounded angles give a vector that is not quite of length one, and it is normalised; ValueError
    where rounding cannot be why.
    """
    cosines = np.cos(np.radians(angles))
    excess = np.abs((cosines**2).sum(axis=-1) - 1.0)
    if not (excess <= _UNIT_TOLERANCE).all():
        raise ValueError(
            "the squared cosines of an attitude must sum to 1, and those of "
            f"{np.asarray(angles).tolist()} are {excess.max():.3f} off"
        )
    return unit(cosines)


def folded_deg(angles: np.ndarray) -> np.ndarray:
    """The angles [deg] or, where smaller, 180 less these: the sign of each cosine is lost.

    Table 1 of [Zhou2011] holds such angles. Folded component by component, an axis that leans a
    little to one side in one image and to the other in the next seems to lean one way in both, so
    a mean of folded angles is biased; see `experiments.apple`.
    """
    return np.minimum(angles, 180.0 - angles)


def angle_between_deg(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """(...) angles [deg], from 0 to 180, between unit vectors (..., 3)."""
    cross = np.linalg.norm(np.cross(first, second), axis=-1)
    return np.degrees(np.arctan2(cross, (first * second).sum(axis=-1)))


def axis_error_deg(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """(...) angles [deg], from 0 to 90, between axes (..., 3) whose sign does not count."""
    angle = angle_between_deg(first, second)
    return np.minimum(angle, 180.0 - angle)


def rotation_of_fixed_angles(angles_deg: np.ndarray) -> np.ndarray:
    """(n, 3, 3) camera -> robot, of the angles R_x, R_y, R_z (n, 3) [deg] in the tables.

    R = Rz(R_z) Ry(R_y) Rx(R_x): turns about the fixed axes x, y and z in this order. [Zhou2011]
    does not say so. Of all orders, transposes, permutations and signs this one alone brings the
    published camera columns onto the robot columns (`experiments.apple.published`).
    """
    return rotation_about_fixed_axes("xyz", angles_deg)


def opencv_rotation(paper_rotation: np.ndarray) -> np.ndarray:
    """(..., 3, 3) rotation of OpenCV's camera, of that of the camera of [Zhou2011]."""
    return paper_rotation @ PAPER_FROM_OPENCV


def tangent_basis(axis: np.ndarray) -> np.ndarray:
    """(..., 3, 2) two orthonormal columns perpendicular to unit vectors (..., 3)."""
    least = np.eye(3)[np.abs(axis).argmin(axis=-1)]
    first = unit(np.cross(axis, least))
    return np.stack([first, np.cross(axis, first)], axis=-1)
