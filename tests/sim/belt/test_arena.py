import mujoco
import numpy as np
import pytest

from sim.belt.arena import PHYSICS_STEP_S, Cell


def test_physics_options_reach_the_compiled_model(scene):
    option = scene.physics.model.opt
    assert option.timestep == pytest.approx(PHYSICS_STEP_S, rel=1e-12)
    assert option.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    assert option.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
    assert option.solver == mujoco.mjtSolver.mjSOL_NEWTON
    assert option.impratio == 10


def test_depth_planes_are_known(scene):
    model = scene.physics.model
    assert model.vis.map.znear * model.stat.extent == pytest.approx(0.04, rel=1e-6)
    assert model.vis.map.zfar * model.stat.extent == pytest.approx(20.0, rel=1e-6)
    assert model.vis.quality.offsamples == 0


def test_belt_carries_at_height_zero(scene):
    belt = scene.physics.bind(scene.conveyor.belt_geom)
    assert belt.xpos[2] + belt.size[2] == pytest.approx(0.0)


def test_lights_are_dimmed_and_restored(scene):
    model = scene.physics.model
    compiled = model.light_diffuse.copy(), model.vis.headlight.ambient.copy()
    scene.cell.set_light_scale(scene.physics, 0.25)
    np.testing.assert_allclose(model.light_diffuse, 0.25 * compiled[0], rtol=1e-6)
    np.testing.assert_allclose(model.vis.headlight.ambient, 0.25 * compiled[1], rtol=1e-6)
    scene.cell.set_light_scale(scene.physics, 1.0)
    np.testing.assert_allclose(model.light_diffuse, compiled[0], rtol=1e-6)


def test_light_scale_refuses_negative_values(scene):
    with pytest.raises(ValueError, match="scale must be"):
        scene.cell.set_light_scale(scene.physics, -0.1)


def test_only_the_key_light_can_cast_shadows():
    key, fill = Cell().lights
    assert (key.castshadow, fill.castshadow) == ("true", "false")


def test_same_start_gives_the_same_bits(scene):
    runs = []
    for _ in range(2):
        with scene.physics.reset_context():
            scene.robot.set_configuration(scene.physics, np.zeros(6), 0.05)
            scene.place_box(0.50, -1.0, 0.3)
            scene.conveyor.set_speed(scene.physics, 0.4)
        scene.robot.command_arm(scene.physics, np.full(6, 0.1), np.zeros(6))
        scene.step(0.5)
        runs.append(scene.physics.data.qpos.copy())
    np.testing.assert_array_equal(*runs)
