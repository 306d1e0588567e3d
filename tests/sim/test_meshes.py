import importlib

import mujoco
import numpy as np
import pytest

from sim import ASSETS


@pytest.fixture(scope="module")
def generator():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(ASSETS))  # as where the script is run
        return importlib.import_module("generate")


def numbers(text: str) -> np.ndarray:
    """Every number of a Wavefront file, in order."""
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    return np.array([float(n) for line in lines for n in line.replace("/", " ").split()[1:]])


def test_committed_meshes_are_what_the_generator_writes(generator):
    written = generator.generate()
    assert {str(p.relative_to(ASSETS)) for p in ASSETS.rglob("*.obj")} == set(written)
    for name, text in written.items():
        committed = numbers((ASSETS / name).read_text())
        np.testing.assert_allclose(numbers(text), committed, atol=2e-6, err_msg=name)


def test_surfaces_are_closed_and_face_outwards(generator):
    meshes = generator.arm_meshes() | generator.gripper_meshes()
    for name, mesh in meshes.items():
        edges = mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        directed = {tuple(edge) for edge in edges.tolist()}
        assert len(directed) == len(edges), name
        assert {edge[::-1] for edge in directed} == directed, name
        assert volume_m3(mesh) > 0, name


def test_objects_have_the_volume_of_their_shape(generator):
    """Facing outwards, or it would be less; edges are seams of the print, so not shared."""
    by_hand = {
        "carton": 0.2 * 0.08 * 0.08,
        "small-carton": 0.12 * 0.06 * 0.06,
        "can": np.pi * 0.033**2 * 0.11,
        "flask": (0.073 * 0.072 + np.pi * 0.036**2) * 0.05,
    }
    made = {name: volume_m3(mesh) for name, mesh in generator.object_meshes().items()}
    assert made == {name: pytest.approx(volume, rel=0.1) for name, volume in by_hand.items()}


def volume_m3(mesh) -> float:
    corners = mesh.vertices[mesh.faces]
    return np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6


@pytest.mark.parametrize(
    "path",
    [
        *("robots/ur5.xml", "robots/ur3.xml", "grippers/rg2.xml", "grippers/soft.xml"),
        *("conveyor.xml", "turntable.xml", "cell.xml"),
    ],
)
def test_model_files_load_on_their_own(path):
    assert mujoco.MjModel.from_xml_path(str(ASSETS / path)).nbody >= 1


def test_drawing_stays_cheap(scene):
    model = scene.physics.model
    drawn = [i for i in model.geom_dataid if i >= 0]
    assert model.mesh_vertnum[drawn].sum() < 12_000
    assert not model.mat_reflectance.any()


def test_what_is_only_drawn_does_not_collide_or_weigh(scene):
    model = scene.physics.model
    meshes = model.geom_type == mujoco.mjtGeom.mjGEOM_MESH
    assert meshes.any()
    assert not model.geom_contype[meshes].any()
    assert not model.geom_conaffinity[meshes].any()
    base = scene.physics.bind(scene.robot.mjcf_model.find("body", "base"))
    links = 4.0 + 3.7 + 8.393 + 2.33 + 1.219 + 1.219 + 0.1879
    gripper = 0.78
    assert base.subtreemass == pytest.approx(links + gripper, rel=1e-6)
