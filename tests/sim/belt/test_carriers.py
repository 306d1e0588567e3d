"""Belt and turntable carry at the stated speed, and what is drawn of them moves along."""

import math

import numpy as np
import pytest
from dm_control import mjcf

from sim.belt.arena import Cell
from sim.belt.carriers import (
    BELT_CENTRE_X_M,
    BELT_WIDTH_M,
    CENTRE_M,
    RADIUS_M,
    Pose,
    Turntable,
)
from sim.belt.objects import OBJECTS, Prop


@pytest.mark.parametrize("speed_mps", [0.1, 0.25, 0.5, 1.0])
def test_box_rides_at_belt_speed(scene, speed_mps):
    scene.place_box(0.50, -1.10, 0.6)
    scene.conveyor.set_speed(scene.physics, speed_mps)
    scene.step(0.3)
    start, duration_s = scene.box_joint.qpos.copy(), 1.0 / speed_mps
    steps = round(duration_s / scene.physics.timestep())
    scene.physics.step(steps)
    end = scene.box_joint.qpos
    travelled = end[1] - start[1]
    assert travelled == pytest.approx(speed_mps * steps * scene.physics.timestep(), rel=1e-3)
    np.testing.assert_allclose(end[[0, 2, 3, 4, 5, 6]], start[[0, 2, 3, 4, 5, 6]], atol=1e-4)


def test_belt_speed_changes_while_running(scene):
    for speed_mps in (0.5, 0.0, 0.2):
        scene.conveyor.set_speed(scene.physics, speed_mps)
        scene.step(0.3)
        assert scene.box_joint.qvel[1] == pytest.approx(speed_mps, abs=1e-3)


def test_belt_lies_where_the_constants_say(scene):
    belt = scene.physics.bind(scene.conveyor.solid_geoms[0])
    low, high = belt.xpos - belt.size, belt.xpos + belt.size
    np.testing.assert_allclose(low[:2], [BELT_CENTRE_X_M - BELT_WIDTH_M / 2, -1.30])
    np.testing.assert_allclose(high, [BELT_CENTRE_X_M + BELT_WIDTH_M / 2, 1.30, 0.0])


def test_rails_guide_without_dragging(scene):
    rail = scene.physics.bind(scene.conveyor.solid_geoms[2])
    inside_x = rail.xpos[0] - rail.size[0]
    scene.place_box(inside_x - 0.0401, -1.0, np.pi / 2)
    scene.conveyor.set_speed(scene.physics, 0.5)
    scene.step(0.3)
    scene.box_joint.qvel[0] = 0.1  # pushed against the rail
    scene.step(0.5)
    assert scene.box_joint.qpos[0] < inside_x - 0.038
    assert scene.box_joint.qvel[1] == pytest.approx(0.5, rel=1e-2)
    assert abs(2 * np.arcsin(scene.box_joint.qpos[6]) - np.pi / 2) < 0.02


def test_drawn_belt_keeps_up_with_the_surface(scene):
    conveyor, physics = scene.conveyor, scene.physics
    band = conveyor.mjcf_model.find("geom", "band")
    random_state = np.random.RandomState(0)
    conveyor.initialize_episode(physics, random_state)
    conveyor.set_speed(physics, 0.25)
    travelled = 0.0
    for _ in range(120):
        physics.step(4)
        conveyor.after_step(physics, random_state)
        travelled += 0.25 * 4 * physics.timestep()
        shift = physics.bind(band).xpos[1]
        assert -0.05 <= shift < 0.05
        assert (travelled - shift) / 0.1 == pytest.approx(
            round((travelled - shift) / 0.1), abs=1e-6
        )
    conveyor.initialize_episode(physics, random_state)
    assert physics.bind(band).xpos[1] == pytest.approx(0.0, abs=1e-12)


@pytest.fixture(scope="module")
def turning():
    cell, table, box = Cell(), Turntable(), Prop(OBJECTS["box"])
    cell.attach_carrier(table)
    cell.add_free_entity(box)
    return table, box, mjcf.Physics.from_mjcf_model(cell.mjcf_model)


def ride(turning, speed_mps: float, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Start and end (x, y from the axis, yaw) of a box that rides at the radius, long axis out."""
    table, box, physics = turning
    x, y = CENTRE_M[0] + RADIUS_M, CENTRE_M[1]
    with physics.reset_context():
        box.set_pose(physics, (x, y, 0.04), (1.0, 0.0, 0.0, 0.0))
        vx, vy, yaw_rate = table.velocity_at(Pose(x, y, 0.0), speed_mps)
        box.set_velocity(physics, (vx, vy, 0.0), (0.0, 0.0, yaw_rate))
    table.set_speed(physics, speed_mps)
    start = np.array([RADIUS_M, 0.0, 0.0])
    physics.step(round(seconds / physics.timestep()))
    position, quaternion = box.get_pose(physics)
    yaw = 2.0 * math.atan2(quaternion[3], quaternion[0])
    return start, np.array([*(position[:2] - CENTRE_M), yaw])


@pytest.mark.parametrize("speed_mps", [0.25, -0.5])
def test_box_goes_round_at_the_stated_speed(turning, speed_mps):
    seconds = 1.0
    _, end = ride(turning, speed_mps, seconds)
    angle = math.atan2(end[1], end[0])
    assert angle * RADIUS_M == pytest.approx(speed_mps * seconds, rel=5e-3)
    assert math.hypot(*end[:2]) == pytest.approx(RADIUS_M, abs=2e-3)
    assert math.remainder(end[2] - angle, 2 * math.pi) == pytest.approx(0.0, abs=5e-3)


def test_box_rests_on_the_still_table(turning):
    start, end = ride(turning, 0.0, 1.0)
    np.testing.assert_allclose(end, start, atol=1e-5)


def test_drawn_disc_keeps_up_with_the_surface(turning):
    table, _, physics = turning
    ride(turning, 0.0, 0.01)
    table.show_mark(physics)
    table.set_speed(physics, 0.25)
    for _ in range(120):
        physics.step(4)
        table.after_step(physics, np.random.RandomState(0))
    physics.step()
    R = physics.bind(table.mjcf_model.find("body", "disc")).xmat.reshape(3, 3)
    expected = 0.25 / RADIUS_M * 480 * physics.timestep()
    assert math.atan2(R[1, 0], R[0, 0]) == pytest.approx(expected, abs=1e-6)
    with physics.reset_context():
        table.show_mark(physics)
    assert physics.bind(table.mjcf_model.find("body", "disc")).xmat[0] == pytest.approx(1.0)
