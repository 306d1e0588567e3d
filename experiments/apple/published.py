"""Tables 1 and 2 of [Zhou2011], as printed: poses of the camera, measured and estimated attitudes.

`published.csv` holds every cell of both. Positions are in millimetres; R_x, R_y and R_z turn about
the robot's fixed axes (`attitude.rotation_of_fixed_angles`). The columns `camera`, `robot` and
`estimate` are the angles [deg] of the fruit's axis with the axes of the camera (x up, y to the
right, z forward), with those of the robot as measured in one image, and after the filter.

The paper prints three angles and no convention. `readings` applies every order of the three turns,
each with its inverse, and every assignment of signed camera axes to the camera columns; the
residual against the robot columns tells the readings apart. Signs of the robot's axes do not
matter, as the comparison folds angles (Table 1 is printed folded).
"""

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import permutations, product
from pathlib import Path

import numpy as np

from tracker.apple.attitude import (
    axis_of_angles,
    folded_deg,
    opencv_rotation,
    rotation_of_fixed_angles,
)
from tracker.apple.hypotheses import solved
from tracker.apple.view import CameraPose
from tracker.geometry import rotation_about_fixed_axes

TABLES = (1, 2)
_PATH = Path(__file__).with_name("published.csv")
_TRUE_ANGLES_DEG = {1: (90.0, 90.0, 0.0), 2: (47.0, 47.0, 76.0)}
"""[Zhou2011] section 4. The squared cosines of the second sum to 0.989, which rounding to whole
degrees does not explain; its direction is taken."""
IDENTIFIED = ("xyz", False, "+x +y +z")
"""R = Rz Ry Rx, camera to robot, of the camera's axes as they are: what `attitude` uses."""


@dataclass(frozen=True, eq=False)
class PublishedTable:
    """One table, a row for each image."""

    number: int
    position_m: np.ndarray
    """(n, 3) of the camera."""
    fixed_angles_deg: np.ndarray
    """(n, 3) R_x, R_y, R_z of the camera."""
    camera_deg: np.ndarray
    """(n, 3) attitude in the camera's frame."""
    robot_deg: np.ndarray
    """(n, 3) attitude in the robot's frame, by one image."""
    estimate_deg: np.ndarray
    """(n, 3) attitude in the robot's frame, by the filter."""

    @property
    def rotation(self) -> np.ndarray:
        """(n, 3, 3) camera of [Zhou2011] -> robot."""
        return rotation_of_fixed_angles(self.fixed_angles_deg)

    @property
    def robot_axes(self) -> np.ndarray:
        """(n, 3) the robot column as vectors."""
        return np.cos(np.radians(self.robot_deg))

    @property
    def converted(self) -> np.ndarray:
        """(n, 3) the camera column as vectors in the robot's frame, signs kept."""
        cosines = np.cos(np.radians(self.camera_deg))
        return (self.rotation @ cosines[..., None])[..., 0]

    @property
    def true_deg(self) -> np.ndarray:
        """(3,) attitude that was set up, in the robot's frame."""
        return np.array(_TRUE_ANGLES_DEG[self.number])

    @property
    def true_axis(self) -> np.ndarray:
        """(3,) the same as a unit vector."""
        return axis_of_angles(self.true_deg)

    @property
    def camera_poses(self) -> list[CameraPose]:
        """The camera's poses with OpenCV's axes, to be taken again."""
        rotations = opencv_rotation(self.rotation)
        return [CameraPose(R, p) for R, p in zip(rotations, self.position_m, strict=True)]

    @property
    def fruit_m(self) -> np.ndarray:
        """(3,) point nearest to all optical axes: where the fruit hung, which is not printed.

        Source: least squares of the distances to the lines of sight.
        """
        forward = self.rotation[:, :, 2]
        across = np.eye(3) - forward[:, :, None] * forward[:, None, :]
        right = (across @ self.position_m[..., None]).sum(axis=0)
        return solved(across.sum(axis=0), right)[:, 0]


@cache
def published_table(number: int) -> PublishedTable:
    """Table 1 (axis vertical, calyx hidden) or 2 (calyx in sight)."""
    if number not in TABLES:
        raise ValueError(f"table must be one of {', '.join(map(str, TABLES))}; got {number}")
    with _PATH.open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["table"] == str(number)]

    def columns(prefix: str, unit: str) -> np.ndarray:
        values = np.array(
            [[float(row[f"{prefix}_{axis}_{unit}"]) for axis in "xyz"] for row in rows]
        )
        values.setflags(write=False)
        return values

    return PublishedTable(
        number=number,
        position_m=columns("p", "mm") / 1000.0,
        fixed_angles_deg=columns("r", "deg"),
        camera_deg=columns("camera", "deg"),
        robot_deg=columns("robot", "deg"),
        estimate_deg=columns("estimate", "deg"),
    )


@dataclass(frozen=True)
class Reading:
    """One convention, and how well it explains the tables."""

    order: str
    """Fixed axes in the order of the turns."""
    is_inverse: bool
    """True where the product of the turns leads from the robot's frame to the camera's."""
    camera_axes: str
    """The axes that the tables call the camera's x, y and z."""
    residual_deg: tuple[float, ...]
    """Mean size of the residuals of each table."""

    @property
    def key(self) -> tuple[str, bool, str]:
        """The three choices that tell one convention from another."""
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
