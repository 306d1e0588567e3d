"""Which reading of R_x, R_y, R_z the published tables support: all of them, tried.

[Zhou2011] prints three angles and no convention. Every order of the three turns, each with its
inverse, and every assignment of signed camera axes is applied to the camera columns; the residual
against the robot columns tells the readings apart. Signs of the robot's axes do not matter, as the
comparison folds angles (Table 1 is printed folded).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from experiments.apple.published import TABLES, PublishedTable, published_table
from tracker.apple.attitude import folded_deg
from tracker.geometry import rotation_about_fixed_axes

IDENTIFIED = ("xyz", False, "+x +y +z")
"""R = Rz Ry Rx, camera to robot, of the camera's axes as they are: what `attitude` uses."""


@dataclass(frozen=True)
class Reading:
    """One convention, and how well it explains the tables."""

    order: str
    """Fixed axes in the order of the turns."""
    is_inverse: bool
    """Whether the product is robot -> camera."""
    camera_axes: str
    """What stands for the camera's x, y and z."""
    residual_deg: tuple[float, ...]
    """Mean size of the residuals of each table."""

    @property
    def key(self) -> tuple[str, bool, str]:
        """What tells it from others."""
        return self.order, self.is_inverse, self.camera_axes


def readings() -> list[Reading]:
    """All readings, the best first by the mean of both tables."""
    tables = [published_table(number) for number in TABLES]
    found = [
        Reading(order, is_inverse, name, tuple(_residual(t, order, is_inverse, M) for t in tables))
        for order in map("".join, permutations("xyz"))
        for is_inverse in (False, True)
        for name, M in _signed_axes()
    ]
    return sorted(found, key=lambda reading: float(np.mean(reading.residual_deg)))


def _signed_axes() -> Iterator[tuple[str, np.ndarray]]:
    """Names and matrices of the axes' permutations with signs; a common sign is no difference."""
    for axes in permutations(range(3)):
        for signs in product((1, -1), repeat=2):
            all_signs = (1, *signs)
            name = " ".join(
                ("+" if sign > 0 else "-") + "xyz"[axis]
                for sign, axis in zip(all_signs, axes, strict=True)
            )
            yield name, np.array(all_signs)[:, None] * np.eye(3)[list(axes)]


def _residual(table: PublishedTable, order: str, is_inverse: bool, M: np.ndarray) -> float:
    R = rotation_about_fixed_axes(order, table.fixed_angles_deg)
    if is_inverse:
        R = np.swapaxes(R, -1, -2)
    cosines = np.cos(np.radians(table.camera_deg)) @ M.T
    converted = (R @ cosines[..., None])[..., 0]
    angles = np.degrees(np.arccos(np.clip(converted, -1.0, 1.0)))
    return float(np.abs(folded_deg(angles) - folded_deg(table.robot_deg)).mean())
