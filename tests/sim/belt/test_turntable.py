"""The turntable: it carries round at the stated speed, and what is drawn turns along."""

import math

import numpy as np
import pytest
from dm_control import mjcf

from sim.belt.arena import Cell
from sim.belt.objects import OBJECTS, Prop
from sim.belt.path import Pose
from sim.belt.turntable import CENTRE_M, RADIUS_M, Turntable


@pytest.fixture(scope="module")
def scene():
    cell, table, box = Cell(), Turntable(), Prop(OBJECTS["box"])
    cell.attach_carrier(table)
    cell.add_free_entity(box)
    return table, box, mjcf.Physics.from_mjcf_model(cell.mjcf_model)


def ride(scene, speed_mps: float, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Start and end (x, y from the axis, yaw) of a box that rides at the radius, long axis out."""
    table, box, physics = scene
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
def test_box_goes_round_at_the_stated_speed(scene, speed_mps):
    seconds = 1.0
    _, end = ride(scene, speed_mps, seconds)
    angle = math.atan2(end[1], end[0])
    assert angle * RADIUS_M == pytest.approx(speed_mps * seconds, rel=5e-3)
    assert math.hypot(*end[:2]) == pytest.approx(RADIUS_M, abs=2e-3)
    assert math.remainder(end[2] - angle, 2 * math.pi) == pytest.approx(0.0, abs=5e-3)


def test_box_rests_on_the_still_table(scene):
    start, end = ride(scene, 0.0, 1.0)
    np.testing.assert_allclose(end, start, atol=1e-5)


def test_drawn_disc_keeps_up_with_the_surface(scene):
    table, _, physics = scene
    ride(scene, 0.0, 0.01)
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
