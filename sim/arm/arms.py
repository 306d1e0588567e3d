"""The arms: published kinematics and joint speeds; masses and torques are in their models."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

JOINT_NAMES = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
"""Order of every joint vector q."""

_DH_ALPHA_RAD = (np.pi / 2, 0.0, 0.0, np.pi / 2, -np.pi / 2, 0.0)
"""The same for every arm of the maker."""


@dataclass(frozen=True)
class Arm:
    """A six-joint arm of Universal Robots (CB3)."""

    xml: str
    """Path of the MJCF file inside the assets folder."""
    dh_a_m: tuple[float, ...]
    """Link lengths of the Denavit-Hartenberg table [UR5DH]."""
    dh_d_m: tuple[float, ...]
    """Link offsets of the same table."""
    joint_speed_radps: tuple[float, ...]
    """Largest speed of each joint [URDescription]."""

    def forward(self, q_rad: np.ndarray) -> np.ndarray:
        """Pose of the flange in the arm's mounting frame, from the published DH table.

        The Denavit-Hartenberg base frame is the mounting frame (that of the model, x towards the
        belt) turned by half a circle about z. Source: [UR5DH], tables of the CB3 arms.

        Args:
            q_rad: (6,) joint angles in the order of JOINT_NAMES.

        Returns:
            (4, 4) T_mount_flange; z of the flange points out of the arm.
        """
        T = np.diag([-1.0, -1.0, 1.0, 1.0])
        table = zip(q_rad, self.dh_a_m, self.dh_d_m, _DH_ALPHA_RAD, strict=True)
        for q, a, d, alpha in table:
            c, s = np.cos(q), np.sin(q)
            ca, sa = np.cos(alpha), np.sin(alpha)
            T = T @ np.array(
                [
                    [c, -s * ca, s * sa, a * c],
                    [s, c * ca, -c * sa, a * s],
                    [0.0, sa, ca, d],
                    [0.0, 0.0, 0.0, 1.0],
                ]
            )
        return T


UR5 = Arm(
    xml="robots/ur5.xml",
    dh_a_m=(0.0, -0.425, -0.39225, 0.0, 0.0, 0.0),
    dh_d_m=(0.089159, 0.0, 0.0, 0.10915, 0.09465, 0.0823),
    joint_speed_radps=(np.pi,) * 6,
)

UR3 = Arm(
    xml="robots/ur3.xml",
    dh_a_m=(0.0, -0.24365, -0.21325, 0.0, 0.0, 0.0),
    dh_d_m=(0.1519, 0.0, 0.0, 0.11235, 0.08535, 0.0819),
    joint_speed_radps=(np.pi,) * 3 + (2 * np.pi,) * 3,
)
