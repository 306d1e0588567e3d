"""Writes results/reach/NAME.md: where an arm can stand beside the belt, by its DH table alone.

python scripts/reach_tables.py

For each place of the base: how far along the belt, both ways, the hand reaches while it points
down, and how fast the belt may run until a joint is too slow to follow it there.
"""

from __future__ import annotations

import math
from itertools import product
from pathlib import Path

import numpy as np

from sim.arm.embodiments import EMBODIMENTS, Arm, Embodiment
from sim.arm.robot import Robot
from sim.belt.scenario import ScenarioRange

FOLDER = Path(__file__).resolve().parents[1] / "results" / "reach"
OBJECT_HEIGHT_M = 0.08
STEP_M = 0.005
PLACES = {
    "ur5-rg2": ((0.40, 0.50, 0.60), (0.00, 0.15, 0.30)),
    "ur3-soft": ((0.28, 0.32, 0.36, 0.40), (0.00, 0.10, 0.20, 0.30)),
}
"""Distances from the arm's axis to the middle of the belt, and heights of the base above it [m]."""


def hand_down(arm: Arm, hand_m: float, position_m: np.ndarray) -> np.ndarray | None:
    """(6,) joints, elbow up, of a hand that points down at a position in the mounting frame.

    Args:
        arm: Its DH table.
        hand_m: From the flange to the tool centre point.
        position_m: (3,) tool centre point.

    Returns:
        None where the arm does not reach.
    """
    upper, fore = -arm.dh_a_m[1], -arm.dh_a_m[2]
    shoulder_m, _, _, aside_m, wrist_m, flange_m = arm.dh_d_m
    x, y, z = position_m
    radius = math.hypot(x, y)
    if radius <= aside_m:
        return None
    out = math.sqrt(radius**2 - aside_m**2) - wrist_m
    up = z + hand_m + flange_m - shoulder_m
    c = (out**2 + up**2 - upper**2 - fore**2) / (2.0 * upper * fore)
    if abs(c) > 1.0:
        return None
    elbow = math.acos(c)
    lean = math.atan2(fore * math.sin(elbow), upper + fore * math.cos(elbow))
    lift = -(math.atan2(up, out) + lean)
    pan = math.atan2(y, x) - math.asin(aside_m / radius)
    q = np.array([pan, lift, elbow, -0.5 * math.pi - lift - elbow, -0.5 * math.pi, pan])
    T = arm.forward(q)
    if not np.allclose(T[:3, 3] + hand_m * T[:3, 2], position_m, atol=1e-9):
        raise AssertionError("inverse and forward kinematics disagree")
    return q


def reach_m(arm: Arm, hand_m: float, x_m: float, heights_m: list[float]) -> float:
    """How far along the belt, at all of these heights; 0 where it does not reach straight ahead."""
    steps = 0
    while all(
        hand_down(arm, hand_m, np.array([x_m, steps * STEP_M, z])) is not None for z in heights_m
    ):
        steps += 1
    return max(steps - 1, 0) * STEP_M


def belt_speed_mps(arm: Arm, hand_m: float, position_m: np.ndarray) -> float:
    """Belt speed at which the first joint runs at its limit; the hand keeps its yaw."""
    ahead_m = 1e-6
    here, there = (
        hand_down(arm, hand_m, position_m + np.array([0.0, step, 0.0])) for step in (0.0, ahead_m)
    )
    if here is None or there is None:
        return 0.0
    rates = np.abs(there - here) / ahead_m
    return float(np.min(np.array(arm.joint_speed_radps) / np.maximum(rates, 1e-9)))


def table(embodiment: Embodiment, distances_m: tuple, bases_m: tuple) -> str:
    """The Markdown table of one embodiment."""
    arm, grasp = embodiment.arm, embodiment.grasp
    hand_m = float(Robot(embodiment).tcp_site.pos[2])
    low = OBJECT_HEIGHT_M - grasp.depth_m
    hover = OBJECT_HEIGHT_M + grasp.hover_m
    near, far = ScenarioRange().offset_m
    lines = [
        "| belt from base [m] | base above belt [m] | reach, near lane [m] | middle [m] "
        "| far lane [m] | fastest belt ahead, near lane [m/s] | at 0.8 of the middle's reach |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for distance, base in product(distances_m, bases_m):
        heights = [z - base for z in (low, hover, low + grasp.lift_m)]
        reaches = [reach_m(arm, hand_m, distance + lane, heights) for lane in (near, 0.0, far)]
        places = ((distance + near, 0.0), (distance, 0.8 * reaches[1]))
        speeds = [
            min(belt_speed_mps(arm, hand_m, np.array([x, y, z])) for z in heights[:2])
            for x, y in places
        ]
        cells = [distance, base, *reaches, *speeds]
        lines.append("| " + " | ".join(f"{cell:.2f}" for cell in cells) + " |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Writes a table for each embodiment."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name, embodiment in EMBODIMENTS.items():
        path = FOLDER / f"{name}.md"
        path.write_text(table(embodiment, *PLACES[name]), encoding="utf-8")
        print(path)


if __name__ == "__main__":
    main()
