"""Tables 1 and 2 of [Zhou2011], as printed: poses of the camera, measured and estimated attitudes.

`published.csv` holds every cell of both. Positions are in millimetres; R_x, R_y and R_z turn about
the robot's fixed axes (`attitude.rotation_of_fixed_angles`). The columns `camera`, `robot` and
`estimate` are the angles [deg] of the fruit's axis with the axes of the camera (x up, y to the
right, z forward), with those of the robot as measured in one image, and after the filter.
"""

import csv
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from tracker.apple.attitude import axis_of_angles, opencv_rotation, rotation_of_fixed_angles
from tracker.apple.hypotheses import solved
from tracker.apple.view import CameraPose

TABLES = (1, 2)
_PATH = Path(__file__).with_name("published.csv")
_TRUE_ANGLES_DEG = {1: (90.0, 90.0, 0.0), 2: (47.0, 47.0, 76.0)}
"""[Zhou2011] section 4. The squared cosines of the second sum to 0.989, which rounding to whole
degrees does not explain; its direction is taken."""


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
