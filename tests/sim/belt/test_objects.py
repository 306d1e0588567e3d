import numpy as np
import pytest
from dm_control import mjcf

from sim import ASSETS
from sim.arm.embodiments import RG2
from sim.belt.arena import Cell
from sim.belt.carriers import BELT_CENTRE_X_M, Conveyor
from sim.belt.objects import OBJECTS, Prop


@pytest.fixture(params=sorted(OBJECTS))
def spec(request):
    return OBJECTS[request.param]


def test_registry_entry_is_filed_under_its_name(spec):
    assert OBJECTS[spec.name] is spec
    assert (ASSETS / spec.xml).is_file()


def test_origin_of_the_file_is_told(spec):
    assert f"`{spec.xml}`" in (ASSETS / "PROVENANCE.md").read_text(encoding="utf-8")


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


def test_fingers_hold_the_object_and_stay_off_the_belt(spec):
    tip_below_tcp_m = 0.032
    height_m = spec.size_m[2]
    assert height_m - spec.grasp_depth_m > tip_below_tcp_m + 0.01
    assert spec.grasp_depth_m >= 0.0


def on_the_belt(spec):
    """Prop, physics and bound joint of the object on a belt that stands still."""
    cell, conveyor, prop = Cell(), Conveyor(), Prop(spec)
    cell.attach_carrier(conveyor)
    cell.add_free_entity(prop)
    physics = mjcf.Physics.from_mjcf_model(cell.mjcf_model)
    conveyor.set_speed(physics, 0.0)
    return prop, physics, physics.bind(mjcf.get_frame_freejoint(prop.mjcf_model))


def test_object_rests_on_the_still_belt(spec):
    _, physics, joint = on_the_belt(spec)
    with physics.reset_context():
        joint.qpos = [BELT_CENTRE_X_M, 0.0, 0.5 * spec.size_m[2] + 1e-4, 1, 0, 0, 0]
    physics.step(96)
    settled = joint.qpos.copy()
    physics.step(480)
    np.testing.assert_allclose(joint.qpos, settled, atol=1e-5)
    assert settled[2] == pytest.approx(0.5 * spec.size_m[2], abs=1e-3)


def test_face_has_the_outline_of_the_object():
    """Share of the bounding rectangle: a disc has pi / 4; the flask two half discs, no neck."""
    straight, radius = 0.073, 0.036
    by_hand = {
        "box": 1.0,
        "can": np.pi / 4,
        "flask": (2 * straight * radius + np.pi * radius**2) / (0.190 * 0.072),
    }
    for name, share in by_hand.items():
        prop, physics, joint = on_the_belt(OBJECTS[name])
        with physics.reset_context():
            height_m = 0.5 * OBJECTS[name].size_m[2]
            joint.qpos = [BELT_CENTRE_X_M, 0.1, height_m, np.cos(0.4), 0, 0, np.sin(0.4)]
        face = prop.face(physics, (60, 90))
        assert face.mean() == pytest.approx(share, abs=0.03), name
    assert face[:, :60].mean() > 2 * face[:, 60:].mean()  # the flask's neck is at +x


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
