"""The robots: an arm, a gripper, where they stand beside the belt, and how they grasp.

Arms have their published kinematics and joint speeds, grippers what a command may ask of them;
masses, torques, forces and springs are in their models.
"""

from dataclasses import dataclass, field

import numpy as np

from sim.arm.grasp import GraspConfig
from sim.checks import look_up

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


@dataclass(frozen=True)
class Gripper:
    """A gripper of two fingers that one drive moves alike."""

    xml: str
    """Path of the MJCF file inside the assets folder."""
    stroke_m: float
    """Largest opening, as the drive has it: between the pads of straight fingers."""
    speed_mps: float
    """Rate at which the opening changes, both fingers together."""
    force_n: float
    """Largest closing force of each finger."""


RG2 = Gripper(xml="grippers/rg2.xml", stroke_m=0.110, speed_mps=0.127, force_n=40.0)

SOFT = Gripper(xml="grippers/soft.xml", stroke_m=0.150, speed_mps=0.200, force_n=15.0)
"""Leaning inwards while nothing is held, its pads leave 0.12 m of the stroke; assets/PROVENANCE.md
says where the numbers come from."""


@dataclass(frozen=True)
class Embodiment:
    """A robot in its place. The belt stays where it is, and so do the cameras."""

    description: str
    arm: Arm
    gripper: Gripper
    base_x_m: float
    """World x of the arm's first axis; the middle of the belt is at 0.50 m."""
    base_height_m: float
    """Height of the mounting face above the carrying surface of the belt."""
    pedestal_radius_m: float
    home_q_rad: tuple[float, ...]
    """Waiting pose: elbow up, hand straight down over the middle of the belt at the waiting point
    of `grasp`, fingers along world x."""
    grasp: GraspConfig = field(default_factory=GraspConfig)


UR5_RG2 = Embodiment(
    description="UR5 and two-finger RG2, as in the simulation of [IGPF2021]",
    arm=UR5,
    gripper=RG2,
    base_x_m=0.0,
    base_height_m=0.15,
    pedestal_radius_m=0.085,
    home_q_rad=(-0.980359, -0.937614, 1.064075, -1.697257, -1.570796, -0.980359),
)

UR3_SOFT = Embodiment(
    description="UR3 and soft two-finger gripper, as in the real cell of [IGPF2021]",
    arm=UR3,
    gripper=SOFT,
    base_x_m=0.18,
    base_height_m=0.20,
    pedestal_radius_m=0.070,
    home_q_rad=(-1.012174, -0.955791, 1.335323, -1.950328, -1.570796, -1.012174),
    grasp=GraspConfig(wait_y_m=-0.30, join_y_m=-0.08, open_width_m=SOFT.stroke_m),
)

EMBODIMENTS: dict[str, Embodiment] = {"ur5-rg2": UR5_RG2, "ur3-soft": UR3_SOFT}
"""Every robot a trial can name."""


def get_embodiment(name: str) -> Embodiment:
    """Returns the named embodiment; ValueError for an unknown name."""
    return look_up("embodiment", name, EMBODIMENTS)
