"""The referee on acted scenes: what counts as touch, lift, hold, slip and collision."""

import math

import numpy as np
import pytest

from sim.belt.referee import HOLD_S, PhysicalRecord, Referee

DT = 1.0 / 120.0


@pytest.fixture
def referee(scene) -> Referee:
    return Referee(scene.physics, scene.box, scene.robot)


def box_in_hand(scene, *, offset_m: float = 0.0) -> None:
    """Puts the box across the open hand at home, long axis along the belt."""
    tcp = scene.physics.bind(scene.robot.tcp_site).xpos
    scene.place_box(tcp[0], tcp[1] + offset_m, yaw_rad=math.pi / 2, z_m=tcp[2])
    scene.physics.forward()


def close_and_hold(scene, referee: Referee, duration_s: float) -> None:
    for _ in range(round(duration_s / DT)):
        scene.robot.command_width(scene.physics, 0.0)
        scene.step(DT)
        referee.watch(scene.physics, is_closing_commanded=True)


def grip_in_the_air(scene, referee: Referee, duration_s: float) -> None:
    """Holds the box up by hand until the fingers have it, then for `duration_s`."""
    scene.physics.model.opt.gravity[2] = 0.0
    close_and_hold(scene, referee, 0.6)
    scene.physics.model.opt.gravity[2] = -9.81
    close_and_hold(scene, referee, duration_s)


def test_box_on_the_belt_is_nothing(scene, referee):
    for _ in range(20):
        scene.step(DT)
        referee.watch(scene.physics, is_closing_commanded=False)
    record = referee.record
    assert record.first_touch_s is None and record.lifted_off_s is None
    assert record.held_s == 0.0 and not record.is_over and not record.collision
    assert abs(record.max_height_m) < 1e-3


def test_held_box_is_a_clean_success_after_one_second(scene, referee):
    box_in_hand(scene)
    grip_in_the_air(scene, referee, 0.3)
    assert not referee.record.is_success
    close_and_hold(scene, referee, HOLD_S)
    record = referee.record
    assert record.is_success and record.is_clean_success and record.is_over
    assert record.slip_m is not None and record.slip_m < 0.001
    assert record.grip_error_m is not None and np.abs(record.grip_error_m).max() < 0.001
    assert abs(record.grip_yaw_error_rad) < 0.01


def test_grip_far_off_centre_is_no_clean_success(scene, referee):
    box_in_hand(scene, offset_m=0.03)
    grip_in_the_air(scene, referee, 1.2)
    record = referee.record
    assert record.is_success and not record.is_clean_success
    assert np.linalg.norm(record.grip_error_m) == pytest.approx(0.03, abs=0.002)
    assert abs(record.grip_error_m[0]) < 0.002


def test_touch_before_the_command_is_early(scene, referee):
    tcp = scene.physics.bind(scene.robot.tcp_site).xpos
    scene.place_box(tcp[0] + 0.03, tcp[1], yaw_rad=math.pi / 2, z_m=tcp[2])
    scene.step(DT)
    referee.watch(scene.physics, is_closing_commanded=False)
    assert referee.record.is_early_contact


def test_box_on_the_floor_has_fallen(scene, referee):
    scene.place_box(0.9, 0.5, z_m=-0.6)
    scene.physics.forward()
    referee.watch(scene.physics, is_closing_commanded=False)
    assert referee.record.has_fallen and referee.record.is_over


def test_box_past_the_reach_is_gone(scene, referee):
    scene.place_box(0.5, 0.9)
    scene.physics.forward()
    referee.watch(scene.physics, is_closing_commanded=False)
    assert referee.record.has_left


def test_tilt_and_height_are_measured(scene, referee):
    half = math.radians(15.0) / 2
    scene.box_joint.qpos = [0.5, 0.0, 0.3, math.cos(half), math.sin(half), 0.0, 0.0]
    scene.physics.forward()
    referee.watch(scene.physics, is_closing_commanded=False)
    record = referee.record
    assert record.max_tilt_rad == pytest.approx(math.radians(15.0), abs=1e-6)
    lowest = 0.3 - 0.04 * (math.cos(math.radians(15)) + math.sin(math.radians(15)))
    assert record.max_height_m == pytest.approx(lowest, abs=1e-6)
    assert record.held_s == 0.0  # high, but nothing holds it


def test_hand_on_the_belt_is_a_collision(scene, referee):
    q = scene.robot.q(scene.physics)
    q[1] += 0.45  # shoulder down
    scene.robot.set_configuration(scene.physics, q, 0.11)
    scene.physics.forward()
    referee.watch(scene.physics, is_closing_commanded=False)
    assert " and " in referee.record.collision


def test_clean_success_needs_every_part():
    base = dict(
        close_command_s=1.0,
        first_touch_s=1.2,
        held_s=1.0,
        slip_m=0.001,
        grip_error_m=np.array([0.002, 0.003]),
    )
    assert PhysicalRecord(**base).is_clean_success
    spoilt = [
        {"first_touch_s": 0.9},
        {"held_s": 0.99},
        {"slip_m": 0.006},
        {"slip_m": None},
        {"grip_error_m": np.array([0.0, 0.021])},
        {"max_tilt_rad": 0.2},
    ]
    for change in spoilt:
        assert not PhysicalRecord(**{**base, **change}).is_clean_success
