"""How fast a belt can run for this arm to take an object off it, however well that is tracked.

While the fingers close, the hand has to keep with the object: straight along the belt, without
turning, at the belt's speed. Reach and joint speeds bound on which stretch of the belt it can do
so at which speed; the fastest belt is the one on which the stretch is just as long as the belt
runs until the fingers touch. Nothing else is asked for: no acceleration, no descent, no turn of
the hand, no lift. So this bounds every method from above.
"""

import functools
from dataclasses import dataclass

import numpy as np

from sim.arm.embodiments import Arm, Embodiment, Gripper
from sim.arm.robot import Robot
from sim.belt.carriers import BELT_CENTRE_X_M

GRID_M = 0.04
"""Step along the belt; the speed is interpolated between."""

_LANE_COUNT = 5
_DIFFERENCE_RAD = 1e-6
_TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False)
class FollowingSpeed:
    """Fastest straight motion of the hand along the belt at each place within reach."""

    y_m: np.ndarray
    """(n,) places along the belt, in world coordinates, `GRID_M` apart."""
    speed_mps: np.ndarray
    """(n,) speed at which the fastest joint runs at its limit."""

    def fastest_belt_mps(self, follow_s: float) -> float:
        """Speed of the fastest belt on which the hand can follow without a break for `follow_s`."""
        y_m = np.linspace(float(self.y_m[0]), float(self.y_m[-1]), 20 * len(self.y_m))
        limit = np.interp(y_m, self.y_m, self.speed_mps)
        low, high = 0.0, float(limit.max())
        while high - low > 1e-4:
            speed = 0.5 * (low + high)
            can = _longest_stretch(y_m, limit >= speed) >= speed * follow_s
            low, high = (speed, high) if can else (low, speed)
        return low


def closing_time_s(gripper: Gripper, object_width_m: float, gripper_delay_s: float) -> float:
    """From the close command until the fingers touch an object of that width."""
    return gripper_delay_s + (gripper.stroke_m - object_width_m) / gripper.speed_mps


@functools.cache
def following_speed(embodiment: Embodiment, offset_m: float, tcp_z_m: float) -> FollowingSpeed:
    """Speeds on the line at `offset_m` from the belt's middle, the hand straight down.

    Solves the arm's published kinematics [URDescription] from place to place along the belt,
    starting at the waiting pose, so that elbow and wrist never flip.

    Args:
        embodiment: The arm in its place.
        offset_m: Lateral, positive away from the robot.
        tcp_z_m: Height of the tool centre point above the belt while the fingers close.
    """
    arm, home_rad = embodiment.arm, np.array(embodiment.home_q_rad)
    tcp_from_flange_m = float(Robot(embodiment).tcp_site.pos[2])
    goal = arm.forward(home_rad)
    goal[0, 3] = BELT_CENTRE_X_M + offset_m - embodiment.base_x_m
    goal[2, 3] = tcp_z_m - embodiment.base_height_m + tcp_from_flange_m
    start_y_m = float(goal[1, 3])
    upstream, downstream = (
        _march(arm, home_rad, goal, start_y_m, step_m) for step_m in (-GRID_M, GRID_M)
    )
    places = [*reversed(upstream[1:]), *downstream]
    return FollowingSpeed(*(np.array(column) for column in zip(*places, strict=True)))


def interceptable_share(
    embodiment: Embodiment,
    speeds_mps: np.ndarray,
    offsets_m: tuple[float, float],
    tcp_z_m: float,
    follow_s: float,
) -> np.ndarray:
    """Share of the lanes of a belt from which the hand can take objects, at each belt speed.

    Args:
        embodiment: The arm in its place.
        speeds_mps: (n,) belt speeds.
        offsets_m: Outermost lanes; objects lie anywhere between, uniformly.
        tcp_z_m: Height of the tool centre point above the belt while the fingers close.
        follow_s: How long the hand has to keep with the object, as by `closing_time_s`.

    Returns:
        (n,) shares from 0 to 1.
    """
    lanes = np.linspace(*offsets_m, _LANE_COUNT)
    fastest = [
        following_speed(embodiment, lane, tcp_z_m).fastest_belt_mps(follow_s)
        for lane in lanes.tolist()
    ]
    between = np.interp(np.linspace(*offsets_m, 1001), lanes, fastest)
    return np.mean(between >= np.asarray(speeds_mps)[:, np.newaxis], axis=1)


def _march(
    arm: Arm, q: np.ndarray, goal: np.ndarray, y_m: float, step_m: float
) -> list[tuple[float, float]]:
    """(place, fastest speed) from `y_m` on until the arm, from `q` on, cannot reach farther."""
    places = list[tuple[float, float]]()
    while True:
        goal[1, 3] = y_m
        solved = _solve(arm, goal, q)
        if solved is None:
            return places
        q, jacobian = solved
        rates = np.abs(np.linalg.solve(jacobian, [0.0, 1.0, 0.0, 0.0, 0.0, 0.0]))
        places.append((y_m, 1.0 / float((rates / arm.joint_speed_radps).max())))
        y_m += step_m


def _solve(arm: Arm, goal: np.ndarray, q_rad: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Joint angles of a flange pose near `q_rad` by Newton steps, and their Jacobian (6, 6)."""
    for _ in range(20):
        T = arm.forward(q_rad)
        error = _twist(goal, T)
        jacobian = np.column_stack(
            [_twist(arm.forward(q_rad + d), T) for d in _DIFFERENCE_RAD * np.eye(6)]
        )
        jacobian /= _DIFFERENCE_RAD
        if float(np.abs(error).max()) < _TOLERANCE:
            return q_rad, jacobian
        if np.linalg.cond(jacobian) > 1e4:
            return None
        step = np.linalg.solve(jacobian, error)
        q_rad = q_rad + step * min(1.0, 0.3 / float(np.abs(step).max()))
    return None


def _twist(T_to: np.ndarray, T_from: np.ndarray) -> np.ndarray:
    """(6,) small displacement [m, rad] in the mounting frame that takes one pose to the other."""
    R = T_to[:3, :3] @ T_from[:3, :3].T
    turn = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    return np.concatenate([T_to[:3, 3] - T_from[:3, 3], turn])


def _longest_stretch(y_m: np.ndarray, is_possible: np.ndarray) -> float:
    """Length of the longest run of possible places [m]."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], is_possible.astype(int), [0]])))
    lengths = y_m[edges[1::2] - 1] - y_m[edges[::2]]
    return float(lengths.max()) if len(lengths) else 0.0
