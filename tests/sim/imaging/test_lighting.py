"""Programmes of the light."""

import numpy as np
import pytest

from sim.imaging.lighting import FlickeringLight, SteadyLight, SwitchedLight


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
