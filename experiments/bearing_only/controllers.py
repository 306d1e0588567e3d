"""The controllers: a pose source, a target filter and a control, each by name."""

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

from tracker.bearing_only.control import Manoeuvre
from tracker.bearing_only.pilot import TargetModel
from tracker.checks import require_known

PoseKind: TypeAlias = Literal["slam", "dead-reckoning", "known", "fused"]
"""Monocular SLAM, the sum of the odometry, the truth with the study's error (an oracle), or the
oracle's position fused with the odometry."""


@dataclass(frozen=True)
class Controller:
    """What a study of flights compares."""

    description: str
    manoeuvre: Manoeuvre = "log-det"
    pose: PoseKind = "slam"
    target_model: TargetModel = "straight"
    acceleration_std_mps2: float = 1.0
    """Of the straight target model; a study may scale it."""
    floor_share: float = 0.5
    """1 for no uncertainty floor."""


_METHODS = {
    "published": Controller(
        "the paper's method with the process noise that reproduces its published error",
        manoeuvre="trace",
        acceleration_std_mps2=0.5,
        floor_share=1.0,
    ),
    "gradient": Controller(
        "the paper's method: gradient of the trace, constant velocity, no floor",
        manoeuvre="trace",
        floor_share=1.0,
    ),
    "gradient-floor": Controller(
        "as gradient, with the uncertainty floor",
        manoeuvre="trace",
    ),
    "log-det": Controller("gradient of the information, constant velocity, uncertainty floor"),
    "cubature": Controller(
        "as log-det, with a square-root cubature filter", target_model="cubature"
    ),
    "mixture": Controller("as log-det, straight and turning models mixed", target_model="mixture"),
    "turn": Controller("as log-det, with a turn whose rate is estimated", target_model="turn"),
    "follow": Controller("pure following: no manoeuvre", manoeuvre="none"),
    "random": Controller(
        "a random direction across the line of sight in place of the gradient",
        manoeuvre="random",
        floor_share=1.0,
    ),
    "dead-reckoning": Controller(
        "as gradient, with the sum of the odometry for a pose",
        manoeuvre="trace",
        pose="dead-reckoning",
        floor_share=1.0,
    ),
}


def _of_known_pose(name: str) -> Controller:
    description = f"as {name}, with the true pose (oracle)"
    return replace(_METHODS[name], description=description, pose="known")


CONTROLLERS: dict[str, Controller] = {
    **_METHODS,
    "known-pose": _of_known_pose("gradient"),
    "known-pose-published": _of_known_pose("published"),
    "fused-pose": Controller(
        "as gradient, with the oracle's position and the odometry in one filter",
        manoeuvre="trace",
        pose="fused",
        floor_share=1.0,
    ),
    **{
        f"known-pose-{name}": _of_known_pose(name)
        for name in ("log-det", "cubature", "mixture", "turn")
    },
}
"""Every controller by name."""


ORACLES: tuple[PoseKind, ...] = ("known", "fused")
"""Kinds of pose that read the truth; their flights of several seeds go on at once."""


def get_controller(name: str) -> Controller:
    """The controller; ValueError lists the names for an unknown one."""
    require_known("controller", name, CONTROLLERS)
    return CONTROLLERS[name]
