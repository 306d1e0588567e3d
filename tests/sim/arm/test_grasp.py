"""The grasp state machine, with a hand that goes where it is told."""

import math
from dataclasses import replace

import numpy as np
import pytest

from sim.arm.grasp import Grasp, GraspConfig, Phase
from sim.arm.motion import UniformMotion, top_down_pose

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


def test_hand_has_joined_the_target_when_it_counts_as_with_it():
    motion = target(-0.8, speed_mps=0.5)
    grasp, hand = Grasp(GraspConfig(), DT, 0.05, HOME), HOME
    for step in range(400):
        command = grasp.step(step * DT, motion, step + 1, hand, 0.110)
        if grasp.phase is Phase.SYNC:
            break
        hand, motion = command.T_world_tcp, motion.after(DT)
    assert command.T_world_tcp[1, 3] == motion.position_m[1] and command.twist[1] == 0.5


@pytest.mark.parametrize(("off_m", "turned_rad"), [(0.01, 0.0), (0.0, math.radians(5.0))])
def test_descent_waits_for_a_hand_that_stays_with_the_target(off_m, turned_rad):
    """It is with the target at steps 250 to 252, and from step 254 on."""
    grasp, hand, motion = Grasp(GraspConfig(), DT, 0.05, HOME), HOME, target(-0.8)
    for step in range(400):
        is_off = step < 250 or step == 253
        seen = hand.copy()
        if is_off:
            seen = hand @ top_down_pose(np.zeros(3), -turned_rad) @ top_down_pose(np.zeros(3), 0.0)
            seen[0, 3] += off_m
        hand = grasp.step(step * DT, motion, step + 1, seen, 0.110).T_world_tcp
        motion = motion.after(DT)
        if is_off:
            assert grasp.phase in (Phase.TRACK, Phase.APPROACH)
        if step == 252:
            assert grasp.phase is Phase.SYNC
        if grasp.phase is Phase.DESCEND:
            assert (step - 253) * DT >= GraspConfig().sync_time_s - 1e-9
            return
    raise AssertionError("no descent")


def closing_s(held_width_m: float) -> float:
    """How long the machine closes fingers that stop at that width."""
    grasp, _ = play(target(-0.8), 500, held_width_m)
    return grasp.entered_s[Phase.LIFT] - grasp.entered_s[Phase.CLOSE]


def test_closing_ends_when_the_fingers_stand_still_or_at_its_time_limit():
    moving_s = (0.110 - 0.08) / 0.127
    assert closing_s(0.08) == pytest.approx(moving_s + GraspConfig().grip_settle_s, abs=3 * DT)
    assert closing_s(0.110) == pytest.approx(GraspConfig().close_timeout_s, abs=2 * DT)


def descent(closing_delay_s: float = 0.05) -> tuple[Grasp, UniformMotion, np.ndarray, float]:
    """The machine at the beginning of its descent, with target, hand and time of that step."""
    grasp = Grasp(GraspConfig(), DT, closing_delay_s, HOME)
    hand, motion = HOME, target(-0.8)
    for step in range(400):
        hand = grasp.step(step * DT, motion, step + 1, hand, 0.110).T_world_tcp
        motion = motion.after(DT)
        if grasp.phase is Phase.DESCEND:
            return grasp, motion, hand, (step + 1) * DT
    raise AssertionError(f"no descent; the phase is {grasp.phase}")


def shifted(motion: UniformMotion, by_m: float) -> UniformMotion:
    return replace(motion, position_m=motion.position_m + np.array([by_m, 0.0, 0.0]))


def test_descent_is_broken_off_where_the_target_is_lost_and_begins_again_beside_it():
    grasp, motion, hand, time_s = descent()
    astray = shifted(motion, 0.9 * GraspConfig().abort_error_m)
    hand = grasp.step(time_s, astray, 99, hand, 0.110).T_world_tcp
    assert grasp.phase is Phase.DESCEND, "a small error is corrected on the way down"
    lost = shifted(astray.after(DT), 1.1 * GraspConfig().abort_error_m)
    command = grasp.step(time_s + DT, lost, 99, hand, 0.110)
    assert grasp.phase is Phase.APPROACH and command.width_m == GraspConfig().open_width_m
    for step in range(2, 200):
        lost = lost.after(DT)
        hand = grasp.step(time_s + step * DT, lost, 99, command.T_world_tcp, 0.110).T_world_tcp
        if grasp.phase is Phase.SYNC:
            break
        assert hand[2, 3] > lost.position_m[2] + 0.5 * GraspConfig().hover_m
    assert grasp.phase is Phase.SYNC and abs(hand[0, 3] - lost.position_m[0]) < 1e-9


def test_descent_goes_on_where_the_fingers_are_beside_the_target_already():
    grasp, motion, hand, time_s = descent()
    config, step = GraspConfig(), 0
    while hand[2, 3] > motion.position_m[2] + 0.5 * config.hover_m:
        hand = grasp.step(time_s + step * DT, motion, 99, hand, 0.110).T_world_tcp
        motion, step = motion.after(DT), step + 1
    grasp.step(time_s + step * DT, shifted(motion, 2.0 * config.abort_error_m), 99, hand, 0.110)
    assert grasp.phase is Phase.DESCEND


@pytest.mark.parametrize("closing_delay_s", [0.0, 0.05, 0.1])
def test_fingers_are_closed_so_early_that_they_begin_to_move_at_the_depth(closing_delay_s):
    """[IGPF2021] Eq. (30)."""
    grasp, motion, hand, time_s = descent(closing_delay_s)
    config, left_m = GraspConfig(), []
    while grasp.phase is Phase.DESCEND or len(left_m) < 60:
        left_m.append(hand[2, 3] - (motion.position_m[2] - config.depth_m))
        hand = grasp.step(time_s, motion, 99, hand, 0.110).T_world_tcp
        motion, time_s = motion.after(DT), time_s + DT
    commanded = round((grasp.entered_s[Phase.CLOSE] - grasp.entered_s[Phase.DESCEND]) / DT) - 1
    early_m = closing_delay_s * config.descent_mps
    assert 0.0 <= config.depth_error_m + early_m - left_m[commanded] <= config.descent_mps * DT
    assert abs(left_m[commanded + round(closing_delay_s / DT)]) < 2.0 * config.depth_error_m


def test_bad_configs_are_refused():
    with pytest.raises(ValueError, match="hover_m must be finite, got nan"):
        GraspConfig(hover_m=float("nan"))
    with pytest.raises(ValueError, match="wait_y_m must lie before join_y_m"):
        GraspConfig(wait_y_m=0.9)
