"""The grasp state machine, with a hand that goes where it is told."""

import math

import numpy as np
import pytest

from sim.arm.grasp import Grasp, GraspConfig, Phase, servo_error
from sim.arm.hand_motion import top_down_pose
from sim.arm.target_motion import UniformMotion

DT = 1.0 / 120.0
HOME = top_down_pose(np.array([0.5, -0.55, 0.25]), 0.0)


def target(y_m: float, *, yaw_rad: float = 1.2, speed_mps: float = 0.25) -> UniformMotion:
    return UniformMotion(np.array([0.52, y_m, 0.08]), yaw_rad, np.array([0.0, speed_mps, 0.0]))


def play(motion: UniformMotion, steps: int, held_width_m: float = 0.08) -> tuple[Grasp, list]:
    """Runs the machine with a perfect hand whose fingers stop at `held_width_m`."""
    grasp = Grasp(GraspConfig(), DT, 0.05, HOME)
    hand, width, commands = HOME, 0.110, []
    for step in range(steps):
        command = grasp.step(step * DT, motion, step + 1, hand, width)
        hand = command.T_world_tcp
        if command.width_m < width:
            width = max(width - 0.127 * DT, held_width_m)
        motion = motion.after(DT)
        commands.append(command)
    return grasp, commands


def test_phases_come_in_order_and_end_in_hold():
    grasp, _ = play(target(-0.8), 400)
    assert grasp.phase is Phase.HOLD
    order = [
        Phase.TRACK,
        Phase.APPROACH,
        Phase.SYNC,
        Phase.DESCEND,
        Phase.CLOSE,
        Phase.LIFT,
        Phase.HOLD,
    ]
    assert sorted(grasp.entered_s, key=lambda phase: grasp.entered_s[phase]) == order


def test_without_target_the_hand_stays_at_home_and_open():
    grasp = Grasp(GraspConfig(), DT, 0.05, HOME)
    command = grasp.step(0.0, None, 0, HOME, 0.110)
    assert grasp.phase is Phase.SEARCH
    assert np.array_equal(command.T_world_tcp, HOME)
    assert command.width_m == GraspConfig().open_width_m


def test_too_few_poses_do_not_start_the_approach():
    grasp = Grasp(GraspConfig(track_poses=3), DT, 0.05, HOME)
    grasp.step(0.0, target(-0.8), 1, HOME, 0.110)
    grasp.step(DT, target(-0.8), 2, HOME, 0.110)
    assert grasp.phase is Phase.TRACK


def test_goal_never_jumps_and_carries_its_own_velocity():
    _, commands = play(target(-0.8, speed_mps=0.5), 300)
    positions = np.array([c.T_world_tcp[:3, 3] for c in commands])[3:]
    velocities = np.array([c.twist[:3] for c in commands])[3:]
    difference = np.diff(positions[:, 1]) / DT
    assert np.abs(difference - velocities[:-1, 1]).max() < 0.05
    assert np.abs(np.diff(positions, axis=0)).max() < 0.02


@pytest.mark.parametrize("yaw_rad", [-1.5, -0.4, 0.0, 0.9, 1.57, 3.0])
def test_hand_closes_across_the_object_and_the_wrist_turns_at_most_a_quarter(yaw_rad):
    _, commands = play(target(-0.8, yaw_rad=yaw_rad), 250)
    R = commands[-1].T_world_tcp[:3, :3]
    closing = math.atan2(R[1, 0], R[0, 0])
    assert abs(math.remainder(closing - yaw_rad - math.pi / 2, math.pi)) < 1e-9
    waiting, joining = (math.atan2(y, HOME[0, 3]) for y in (HOME[1, 3], GraspConfig().join_y_m))
    assert abs(closing - (joining - waiting)) <= math.pi / 2 + 1e-9


def test_hand_turns_with_the_base_rather_than_against_it():
    """From -84 degrees at the waiting point the wrist would turn on against the arm's sweep."""
    _, commands = play(target(-0.8, yaw_rad=math.radians(-84.0 - 90.0)), 250)
    R = commands[-1].T_world_tcp[:3, :3]
    assert math.degrees(math.atan2(R[1, 0], R[0, 0])) == pytest.approx(96.0)


def test_half_turn_of_the_estimate_does_not_turn_the_hand():
    grasp = Grasp(GraspConfig(), DT, 0.05, HOME)
    for step in range(10):
        before = grasp.step(step * DT, target(-0.7), step + 3, HOME, 0.11).T_world_tcp
    turned = target(-0.7, yaw_rad=1.2 + math.pi)
    after = grasp.step(10 * DT, turned, 20, HOME, 0.11).T_world_tcp
    assert np.allclose(before[:3, :3], after[:3, :3])


def test_grip_ends_feedback_from_the_object_in_the_hand():
    """Perception of a held object follows the hand; the machine must not follow it back."""
    grasp = Grasp(GraspConfig(), DT, 0.05, HOME)
    hand, width, motion = HOME, 0.110, target(-0.6)
    for step in range(300):
        seen = UniformMotion(hand[:3, 3] + [0.01, 0.0, 0.04], 1.2, motion.velocity_mps)
        believed = seen if width <= 0.08 else motion
        command = grasp.step(step * DT, believed, step + 3, hand, width)
        hand = command.T_world_tcp
        if command.width_m < width:
            width = max(width - 0.127 * DT, 0.08)
        motion = motion.after(DT)
    assert grasp.phase is Phase.HOLD
    assert hand[0, 3] == pytest.approx(0.52, abs=0.012)


def test_servo_error_is_zero_at_the_grasp_and_counts_both_parts():
    motion = target(0.0, yaw_rad=0.3)
    depth = 0.035
    grasp_position = motion.position_m - [0.0, 0.0, depth]
    exact = top_down_pose(grasp_position, 0.3 + math.pi / 2)
    assert servo_error(motion, exact, depth) == pytest.approx(0.0, abs=1e-12)
    turned = top_down_pose(grasp_position, 0.3 + math.pi / 2 + 0.2)
    assert servo_error(motion, turned, depth) == pytest.approx(0.02)
    shifted = top_down_pose(grasp_position + np.array([0.03, 0.0, 0.04]), 0.3 - math.pi / 2)
    assert servo_error(motion, shifted, depth) == pytest.approx(0.05)


def test_bad_configs_are_refused():
    with pytest.raises(ValueError, match="hover_m must be finite, got nan"):
        GraspConfig(hover_m=float("nan"))
    with pytest.raises(ValueError, match="wait_y_m must lie before join_y_m"):
        GraspConfig(wait_y_m=0.9)
