"""The robots: an arm, a gripper, where they stand beside the belt, and how they grasp."""

from __future__ import annotations

from dataclasses import dataclass, field

from sim.arm.arms import UR3, UR5, Arm
from sim.arm.grasp import GraspConfig
from sim.arm.grippers import RG2, SOFT, Gripper
from sim.checks import look_up


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
