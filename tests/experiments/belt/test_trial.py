"""Whole trials in this process: images alone suffice, rows repeat, truth stays outside."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest

from experiments.belt import cell, config, trial
from experiments.belt.cell import Cell, Truth, make_cell
from experiments.belt.config import TrialConfig
from experiments.belt.loop import Loop
from experiments.belt.perception import NoisyOracle, Oracle, Seeing
from sim.arm.grasp import Phase
from sim.belt import environment
from sim.belt.carriers import RADIUS_M
from sim.belt.objects import OBJECTS
from tracker.belt.prediction import make_predictor

IGPF = TrialConfig(tracker="igpf", speed_mps=0.5, seed=1)


@pytest.fixture(scope="module")
def igpf_row():
    return trial.run_trial(IGPF).rows[0]


def test_igpf_lifts_the_box_by_sight(igpf_row):
    assert igpf_row.outcome == "success" and igpf_row.clean_success and igpf_row.criterion_met
    assert igpf_row.track_rmse_m < 0.005
    assert igpf_row.track_yaw_rmse_rad < math.radians(2.0)


def test_same_trial_gives_the_same_row_whatever_ran_before(igpf_row):
    trial.run_trial(TrialConfig(tracker="oracle", speed_mps=0.5, seed=7))
    assert trial.run_trial(IGPF).rows[0] == igpf_row


def test_igpf_lifts_the_box_where_depth_has_noise_and_holes():
    row = trial.run_trial(replace(IGPF, condition="depth-3")).rows[0]
    assert row.outcome == "success" and row.track_rmse_m < 0.005


def test_a_corrected_track_forgets_where_the_wrong_one_went():
    """At this resolution the half of the box that is in view first looks like a whole one."""
    config = TrialConfig(tracker="igpf", speed_mps=0.1, seed=1, condition="resolution-2")
    loop = Loop(config, make_cell(config, has_camera=True))
    while loop.trace.control[-1:] == [] or loop.trace.control[-1].true_position_m[1] < -0.72:
        loop.step()
    first = next(e.time_s for e in loop.trace.estimates if e.position_m is not None)
    assert first < loop.time_s - 0.5
    target, truth = loop.perception.predict(loop.time_s), loop.trace.control[-1]
    np.testing.assert_allclose(target.position_m[:2], truth.true_position_m[:2], atol=6e-3)


def test_tracker_sees_images_only(monkeypatch):
    """With the simulator's truth out of reach, the row of a tracker stays the same."""
    world = make_cell(IGPF, has_camera=True)
    loop = Loop(IGPF, world)
    assert isinstance(loop.perception, Seeing)

    def forbidden(*_: object) -> Truth:
        raise AssertionError("perception read the truth")

    monkeypatch.setattr(Cell, "read_truth", forbidden)
    for _ in range(30):
        loop.perception.update(world.task.image(world.environment.physics))
        loop.perception.predict(loop.time_s)
        action = np.concatenate([world.servo.q, np.zeros(6), [0.11]])
        loop._timestep = world.environment.step(action)
    assert loop.perception.last is not None


@pytest.mark.parametrize("name", OBJECTS)
def test_oracle_lifts_every_object_and_renders_nothing(name):
    (row,) = trial.run_trial(TrialConfig(tracker="oracle", object=name, speed_mps=0.5, seed=1)).rows
    assert row.clean_success and row.gl_renderer == "none"


def test_oracle_lifts_the_box_off_the_turntable():
    config = TrialConfig(tracker="oracle", motion="turntable", seed=2)
    (row,) = trial.run_trial(config).rows
    assert row.clean_success
    angle_rad = row.time_to_grasp_s * config.speed_mps / RADIUS_M
    assert row.belt_used_m == pytest.approx(angle_rad * RADIUS_M, rel=0.2)  # not at the radius


@pytest.mark.slow
def test_igpf_lifts_the_box_off_the_turntable_by_sight():
    (row,) = trial.run_trial(TrialConfig(tracker="igpf", motion="turntable", seed=1)).rows
    assert row.clean_success and row.track_rmse_m < 0.005


@pytest.mark.slow
@pytest.mark.parametrize("name", OBJECTS)
def test_igpf_lifts_every_object_by_sight(name):
    (row,) = trial.run_trial(TrialConfig(tracker="igpf", object=name, seed=1)).rows
    assert row.clean_success and row.track_rmse_m < 0.005


@pytest.mark.parametrize("speed_mps", [0.10, 0.25, 0.50, 1.00])
def test_light_goes_down_after_the_first_look_and_long_before_the_fingers_close(speed_mps):
    setting = TrialConfig(tracker="oracle", condition="switch-3", speed_mps=speed_mps)
    loop = Loop(setting, make_cell(setting, has_camera=False))
    light = loop.cell.task.condition.light
    dark_s = None
    while loop.is_running and Phase.CLOSE not in loop.grasp.entered_s:
        loop.step()
        if dark_s is None and light(loop.time_s, loop.cell.read_truth().position_m[1]) < 1.0:
            dark_s = loop.time_s
    assert dark_s is not None and loop.has_entered_view
    assert dark_s > loop.entered_view_s + 0.05
    assert loop.grasp.entered_s[Phase.CLOSE] > dark_s + 0.5


def test_a_still_belt_ends_in_a_timeout_not_in_an_exception(monkeypatch):
    monkeypatch.setattr(environment, "TIME_LIMIT_S", 2.0)
    monkeypatch.setattr(cell, "_compiled", cell._compiled.__wrapped__)
    (row,) = trial.run_trial(TrialConfig(tracker="oracle", speed_mps=0.0, seed=0)).rows
    (row,) = trial.run_trial(TrialConfig(tracker="oracle", speed_mps=0.0, seed=0)).rows
    assert row.outcome == "timeout" and not row.success


@pytest.fixture
def clock():
    """A truth that moves at 0.3 m/s, and the time it is read at."""

    class Clock:
        time_s = 0.0

        def read(self) -> Truth:
            position = np.array([0.5, 0.3 * self.time_s, 0.08])
            return Truth(self.time_s, position, 0.4, np.array([0.0, 0.3, 0.0]), 0.0)

    return Clock()


def test_oracle_tells_the_truth_of_now(clock):
    oracle = Oracle(clock.read)
    clock.time_s = 0.5
    assert oracle.predict(0.5).position_m[1] == pytest.approx(0.15)


def test_noisy_oracle_keeps_rate_delay_and_noise(clock):
    rng = np.random.default_rng(0)
    noisy = NoisyOracle(clock.read, make_predictor("latest"), 30.0, 0.1, np.eye(4), rng)
    seen = []
    for step in range(1200):
        clock.time_s = step / 120.0
        estimate = noisy.update({})
        if estimate is not None:
            seen.append((clock.time_s, estimate))
    ages = [now - estimate.time_s for now, estimate in seen]
    assert min(ages) >= 0.1 - 1e-9 and max(ages) < 0.1 + 1.1 / 120
    assert len(seen) == pytest.approx(30 * 9.9, abs=2)
    errors = np.array([e.position_m - [0.5, 0.3 * e.time_s, 0.08] for _, e in seen])
    assert np.std(errors) == pytest.approx(0.002, rel=0.1)


def test_config_hash_names_every_field_and_nothing_else():
    assert TrialConfig().trial_id == TrialConfig().trial_id
    changed = [{"seed": 1}, {"delay_s": 0.067}, {"tracker": "pf"}, {"particle_count": 151}]
    ids = {TrialConfig(**change).trial_id for change in changed}
    assert len(ids) == len(changed) and TrialConfig().trial_id not in ids


@pytest.mark.parametrize("other", ["blur-1+dark-1", "dark-01+blur-1", "dark-1+blur-1+dark-1"])
def test_a_condition_has_one_name_and_one_id(other):
    one = TrialConfig(condition="dark-1+blur-1")
    assert TrialConfig(condition=other).trial_id == one.trial_id
    assert one.condition == "blur-1+dark-1"
    assert TrialConfig(condition="drak-1+x").condition == "drak-1+x", "refused elsewhere, whole"


def test_all_that_determines_a_trial_is_in_its_row():
    columns = {field.name for field in fields(config.TrialResult)}
    assert {field.name for field in fields(TrialConfig)} < columns


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("speed_mps", -0.1, "speed_mps must be a number from 0 to 3, got -0.1"),
        ("speed_mps", math.nan, "speed_mps must be a number from 0 to 3, got nan"),
        ("delay_s", 60.0, "delay_s must be a number from 0 to 1, got 60.0"),
        ("camera_rate_hz", 50.0, "camera_rate_hz must divide 480 .* got 50.0"),
        ("particle_count", 0, "particle_count must be 1 or greater, got 0"),
        ("seed", -1, "seed must be 0 or greater, got -1"),
    ],
)
def test_impossible_numbers_are_refused(field, value, message):
    with pytest.raises(ValueError, match=message):
        TrialConfig(**{field: value})
