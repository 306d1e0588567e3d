"""Conditions by name: nothing at level 0, one thing at a time, several joined."""

import numpy as np
import pytest

from sim.imaging.degradations import (
    DEGRADATIONS,
    Condition,
    FlickeringLight,
    SteadyLight,
    SwitchedLight,
    get_condition,
)

LEVELS = [
    f"{name}-{k + 1}" for name, entry in DEGRADATIONS.items() for k in range(len(entry.levels))
]


@pytest.mark.parametrize("name", DEGRADATIONS)
def test_level_0_is_the_normal_condition(name):
    assert get_condition(f"{name}-0") == get_condition("normal") == Condition()


@pytest.mark.parametrize("name", LEVELS)
def test_every_level_changes_something(name):
    assert get_condition(name) != Condition()


@pytest.mark.parametrize("name", DEGRADATIONS)
def test_levels_of_a_degradation_change_the_same_fields(name):
    keys = [set(level) for level in DEGRADATIONS[name].levels]
    assert all(other == keys[0] for other in keys)


def test_several_are_joined():
    condition = get_condition("dark-3+resolution-2+blur-1")
    assert condition.light == SteadyLight(0.15)
    assert (condition.width_px, condition.height_px) == (160, 120)
    assert condition.exposure_s == pytest.approx(1 / 120)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("foggy", "condition must be normal, or NAME-LEVEL with a NAME of dark, .*; got 'foggy'"),
        ("dark", "condition must be normal"),
        ("dark-x", "condition must be normal"),
        ("normal+dark-1", "got 'normal'"),
        ("", "got ''"),
        ("dark-5", "dark has levels 0 to 4, got 'dark-5'"),
        ("dark-1+switch-2", "dark-1 and switch-2 both set light"),
    ],
)
def test_bad_names_are_refused(name, message):
    with pytest.raises(ValueError, match=message):
        get_condition(name)


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("width_px", 0, "width_px must be 16 or greater, got 0"),
        ("exposure_s", -0.1, "exposure_s must be 0 or greater, got -0.1"),
        ("full_well_e", 0.0, "full_well_e must be greater than 0"),
        ("dropped_share", 1.0, "dropped_share must be from 0 to below 1, got 1.0"),
        ("bar_m", 0.6, "bar_m must be a number from 0 to 0.5, got 0.6"),
        ("clutter", -0.1, "clutter must be a number from 0 to 1, got -0.1"),
        ("look_alike_count", 4, "look_alike_count must be 0 to 3, got 4"),
    ],
)
def test_bad_conditions_are_refused(field, value, message):
    with pytest.raises(ValueError, match=message):
        Condition(**{field: value})


def test_steady_light_is_steady():
    assert {SteadyLight(0.3)(time_s, y_m) for time_s in (0.0, 9.0) for y_m in (-1.0, 1.0)} == {0.3}


def test_switch_comes_with_the_target():
    light = SwitchedLight(1.0, 0.15, at_y_m=-0.4)
    assert (light(0.0, -0.41), light(0.0, -0.39)) == (1.0, 0.15)


def test_flicker_at_100_hz_is_a_beat_of_10_hz_in_a_camera_of_30_hz():
    light = FlickeringLight(0.5)
    seen = np.array([light(k / 30, 0.0) for k in range(30)])
    assert seen[3:] == pytest.approx(seen[:-3])
    assert np.ptp(seen) > 0.8


def test_bad_lights_are_refused():
    with pytest.raises(ValueError, match="scale must be a number from 0 to 2, got 3"):
        SteadyLight(3.0)
    with pytest.raises(ValueError, match="after must be a number from 0 to 2, got nan"):
        SwitchedLight(1.0, float("nan"))
    with pytest.raises(ValueError, match="depth must be a number from 0 to 1, got"):
        FlickeringLight(1.5)
