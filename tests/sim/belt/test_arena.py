"""The cell: its physics and lights, and what a condition asks for and nothing else."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from sim.belt.arena import PHYSICS_STEP_S, Cell
from sim.belt.carriers import Pose
from sim.belt.environment import load
from sim.belt.scenario import Scenario, ScenarioRange
from sim.belt.task_config import Episode, TaskConfig
from sim.imaging.degradations import DEGRADATIONS


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
    belt = scene.physics.bind(scene.conveyor.solid_geoms[0])
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


SPEED_MPS = 0.5
SCENARIO = Scenario(
    lambda time_s: SPEED_MPS,
    Pose(0.5, -0.8, 0.3),
    (Pose(0.45, -0.41, 1.0), Pose(0.55, -1.19, 2.0), Pose(0.5, -0.02, 0.0)),
)


@pytest.fixture(scope="module", params=["far-side", "overhead"])
def environment(request):
    environment = load(TaskConfig(camera=request.param, delay_s=0.0), random_state=0)
    yield environment
    environment.task.close()


def begin(environment, condition: str, scenario: Scenario = SCENARIO):
    task = environment.task
    task.configure(replace(task.config, condition=condition))
    task.next_episode = Episode(scenario, np.random.default_rng(0))
    environment.reset()
    rgb, depth_m = task.render(environment.physics, "sensor")
    return rgb.copy(), depth_m.copy()


def still(environment) -> np.ndarray:
    return np.array([*environment.task.robot.q(environment.physics), *np.zeros(6), 0.11])


def led(environment) -> np.ndarray:
    """(4, 3) places of the bar and the look-alikes."""
    return environment.physics.data.mocap_pos.copy()


def test_normal_condition_has_none_of_it_whatever_came_before(environment):
    before = begin(environment, "normal")
    assert (led(environment)[:, 2] < -1.0).all()
    begin(environment, "occlusion-4+clutter-3+distractors-3")
    after = begin(environment, "normal")
    assert (led(environment)[:, 2] < -1.0).all()
    assert all(np.array_equal(a, b) for a, b in zip(before, after, strict=True))


def test_a_wider_bar_hides_more_of_the_same_place(environment):
    _, free_m = begin(environment, "normal")
    task, shares = environment.task, []
    place = np.linalg.inv(task.view.T_world_camera) @ [0.5, -0.595, 0.04, 1.0]
    column, row = np.rint((task.K @ place[:3])[:2] / place[2]).astype(int)
    for level in range(1, len(DEGRADATIONS["occlusion"].levels) + 1):
        _, depth_m = begin(environment, f"occlusion-{level}")
        is_hidden = depth_m < free_m - 0.2
        assert is_hidden[row, column]
        shares.append(is_hidden[row].mean())
    width_px = 0.04 * task.K[0, 0] / (0.5 * place[2])
    expected = width_px * np.arange(1, len(shares) + 1) / task.condition.width_px
    np.testing.assert_allclose(shares, expected, rtol=0.12)


def test_print_is_busier_level_by_level_and_has_no_height(environment):
    rgb, free_m = begin(environment, "normal")
    edges = [np.abs(np.diff(rgb.astype(float), axis=1)).mean()]
    for level in (1, 2, 3):
        rgb, depth_m = begin(environment, f"clutter-{level}")
        edges.append(np.abs(np.diff(rgb.astype(float), axis=1)).mean())
        assert np.abs(depth_m - free_m).max() < 0.01
    assert (np.divide(edges[1:], edges[:-1]) > 1.03).all()  # from 70 % on the belt's own weave goes


def test_look_alikes_ride_along_and_change_nothing_of_the_object(environment):
    ways = {}
    for condition in ("normal", "distractors-2"):
        begin(environment, condition)
        start, object_start = led(environment), environment.task.referee.object_pose
        y_m = object_start(environment.physics)[1, 3]
        for _ in range(60):
            environment.step(still(environment))
        ways[condition] = environment.physics.data.qpos.copy()
        way_m = object_start(environment.physics)[1, 3] - y_m
    np.testing.assert_array_equal(*ways.values())
    moved = led(environment) - start
    np.testing.assert_allclose(moved[1:3], [[0.0, way_m, 0.0]] * 2, atol=1e-3)
    assert way_m == pytest.approx(0.25, rel=0.01)
    np.testing.assert_array_equal(moved[[0, 3]], 0.0)  # no bar, and only two were asked for
    assert led(environment)[3, 2] < -1.0


def test_look_alike_is_seen_on_the_belt_and_taken_away_at_its_end(environment):
    rgb, _ = begin(environment, "normal")
    with_one, _ = begin(environment, "distractors-1")
    changed = np.abs(with_one.astype(int) - rgb).max(axis=2) > 20
    assert 500 < changed.sum() < 0.1 * changed.size
    far = replace(SCENARIO, look_alikes=(Pose(0.5, 1.19, 0.0),))
    begin(environment, "distractors-1", far)
    for _ in range(6):
        environment.step(still(environment))
    assert led(environment)[1, 2] < -1.0


@pytest.mark.parametrize("motion", ["constant", "turntable"])
def test_hand_and_object_have_room_between_the_look_alikes(motion):
    for seed in range(200):
        scenario = ScenarioRange().draw(motion, 0.2, np.random.default_rng(seed))
        poses = [scenario.start, *scenario.look_alikes]
        p = np.array([[pose.x_m, pose.y_m] for pose in poses])
        distances = np.linalg.norm(p[:, None] - p, axis=-1)[np.triu_indices(4, 1)]
        assert distances.min() > 0.29  # half a hand and half the diagonal of a long object
