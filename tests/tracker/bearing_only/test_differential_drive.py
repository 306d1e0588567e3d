import numpy as np

from tracker.bearing_only.differential_drive import DifferentialDrive, WheelDrive

AHEAD = np.array([1.0, 0.0, 0.0])


def wheels():
    return WheelDrive(DifferentialDrive(max_turn_rate_radps=10.0, lean_rad=0.3))


def test_straight_ahead_is_driven_as_wanted():
    step = wheels().convert(np.array([0.2, 0.0, 0.1]), AHEAD, 0.1)
    assert np.allclose(step.displacement_m, [0.02, 0.0, 0.0])
    assert np.allclose(step.rotation_rad, 0.0)


def test_a_wish_to_the_left_leans_as_far_as_the_target_stays_in_view():
    step = wheels().convert(np.array([0.0, 0.2, 0.0]), AHEAD, 0.1)
    assert np.allclose(step.rotation_rad, [0.0, 0.0, 0.3])
    assert np.allclose(step.displacement_m, [0.02, 0.0, 0.0])


def test_backing_off_to_the_left_leans_to_the_right():
    step = wheels().convert(np.array([-0.1, 0.2, 0.0]), AHEAD, 0.1)
    assert step.displacement_m[0] < 0.0
    assert np.isclose(step.rotation_rad[2], -0.3)


def test_the_sense_changes_only_beyond_the_gap():
    drive = wheels()
    drive.convert(np.array([0.2, 0.0, 0.0]), AHEAD, 0.1)
    within = drive.convert(np.array([-0.01, 0.2, 0.0]), AHEAD, 0.1)
    beyond = drive.convert(np.array([-0.1, 0.2, 0.0]), AHEAD, 0.1)
    assert within.displacement_m[0] > 0.0 > beyond.displacement_m[0]


def test_the_turn_is_limited_and_never_sideways():
    drive = WheelDrive(DifferentialDrive(max_turn_rate_radps=1.0))
    rng = np.random.default_rng(0)
    for _ in range(50):
        ray = np.array([1.0, *rng.normal(0.0, 1.0, 2)])
        step = drive.convert(rng.normal(0.0, 0.2, 3), ray, 0.1)
        assert np.all(step.displacement_m[1:] == 0.0)
        assert abs(step.rotation_rad[2]) <= 0.1 + 1e-12
