import numpy as np
import pytest

from sim.belt.conveyor import (
    BELT_CENTRE_X_M,
    BELT_WIDTH_M,
)


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
    belt = scene.physics.bind(scene.conveyor.belt_geom)
    low, high = belt.xpos - belt.size, belt.xpos + belt.size
    np.testing.assert_allclose(low[:2], [BELT_CENTRE_X_M - BELT_WIDTH_M / 2, -1.30])
    np.testing.assert_allclose(high, [BELT_CENTRE_X_M + BELT_WIDTH_M / 2, 1.30, 0.0])


def test_rails_guide_without_dragging(scene):
    rail = scene.physics.bind(scene.conveyor.rail_geoms[1])
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
