import numpy as np
import pytest
from dm_control import mjcf

from sim import ASSETS
from sim.arena import Cell
from sim.conveyor import BELT_CENTRE_X_M, Conveyor
from sim.grippers import RG2
from sim.objects import OBJECTS, Prop


@pytest.fixture(params=sorted(OBJECTS))
def spec(request):
    return OBJECTS[request.param]


def test_registry_entry_is_filed_under_its_name(spec):
    assert OBJECTS[spec.name] is spec
    assert (ASSETS / spec.xml).is_file()


def test_object_compiles_with_its_stated_mass(spec):
    prop = Prop(spec)
    physics = mjcf.Physics.from_mjcf_model(prop.mjcf_model)
    body = physics.bind(prop.body)
    assert body.mass == pytest.approx(spec.mass_kg, rel=1e-6)
    assert np.all(body.inertia > 0)


def test_object_fits_the_gripper(spec):
    long, across, _ = spec.size_m
    assert across + 0.02 <= RG2.stroke_m
    assert long >= across


def test_object_rests_on_the_still_belt(spec):
    cell, conveyor, prop = Cell(), Conveyor(), Prop(spec)
    cell.attach_conveyor(conveyor)
    cell.add_free_entity(prop)
    physics = mjcf.Physics.from_mjcf_model(cell.mjcf_model)
    joint = physics.bind(mjcf.get_frame_freejoint(prop.mjcf_model))
    with physics.reset_context():
        conveyor.set_speed(physics, 0.0)
        joint.qpos = [BELT_CENTRE_X_M, 0.0, 0.5 * spec.size_m[2] + 1e-4, 1, 0, 0, 0]
    physics.step(96)
    settled = joint.qpos.copy()
    physics.step(480)
    np.testing.assert_allclose(joint.qpos, settled, atol=1e-5)
    assert settled[2] == pytest.approx(0.5 * spec.size_m[2], abs=1e-3)


def test_extent_of_the_colliding_geoms_is_the_stated_size(spec):
    prop = Prop(spec)
    physics = mjcf.Physics.from_mjcf_model(prop.mjcf_model)
    solid = physics.bind([g for g in prop.geoms if physics.bind(g).contype])
    R = np.atleast_2d(solid.xmat).reshape(-1, 3, 3)
    aabb = physics.model.geom_aabb[solid.element_id].reshape(-1, 6)
    half = np.einsum("nij,nj->ni", np.abs(R), aabb[:, 3:])
    centre = np.atleast_2d(solid.xpos) + np.einsum("nij,nj->ni", R, aabb[:, :3])
    extent = (centre + half).max(axis=0) - (centre - half).min(axis=0)
    np.testing.assert_allclose(extent, spec.size_m, atol=2e-3)
