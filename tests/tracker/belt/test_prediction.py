import math
from dataclasses import replace

import numpy as np
import pytest

from tracker.belt.backproject import TargetPose
from tracker.belt.prediction import (
    PREDICTORS,
    KalmanConstantVelocity,
    PredictorConfig,
    make_predictor,
)


def pose(time_s, position, yaw=0.0):
    return TargetPose(
        position_m=np.array(position, float),
        yaw_rad=yaw,
        covariance=1e-8 * np.eye(4),
        time_s=time_s,
        visible_fraction=1.0,
        is_usable=True,
    )


MOVING = [name for name in PREDICTORS if name != "latest"]


@pytest.mark.parametrize("name", PREDICTORS)
def test_nothing_before_the_first_pose_then_a_standing_target(name):
    predictor = make_predictor(name)
    assert predictor.predict(0.0) is None
    predictor.update(pose(1.0, [0.5, 0.1, 0.08], 0.3))
    prediction = predictor.predict(1.2)
    np.testing.assert_allclose(prediction.position_m, [0.5, 0.1, 0.08])
    assert prediction.yaw_rad == pytest.approx(0.3)
    assert prediction.age_s == pytest.approx(0.2)


SPINNING = [name for name in MOVING if name != "turning"]


@pytest.mark.parametrize("name", SPINNING)
def test_uniform_motion_and_turning_are_extrapolated(name):
    predictor = make_predictor(name)
    for k in range(40):
        t = k / 30
        yaw = math.remainder(3.0 + 0.5 * t, 2 * math.pi)
        predictor.update(pose(t, [0.5, 0.25 * t, 0.08], yaw))
    prediction = predictor.predict(39 / 30 + 0.1)
    np.testing.assert_allclose(prediction.position_m[1], 0.25 * (1.3 + 0.1), atol=1e-3)
    np.testing.assert_allclose(prediction.velocity_mps, [0, 0.25, 0], atol=5e-3)
    assert prediction.yaw_rad == pytest.approx(3.0 + 0.5 * 1.4, abs=0.01)
    assert prediction.yaw_rate_radps == pytest.approx(0.5, abs=0.03)


def on_turntable(time_s, radius_m=0.25, rate_radps=2.0):
    """Pose of what rides at 0.5 m/s, half a metre before the arm."""
    angle = rate_radps * time_s
    place = [0.5 + radius_m * math.cos(angle), radius_m * math.sin(angle), 0.08]
    return pose(time_s, place, math.remainder(angle, math.tau))


def turntable_error_m(name, ahead_s):
    predictor = make_predictor(name)
    for k in range(30):
        predictor.update(on_turntable(k / 30))
    time_s = 29 / 30 + ahead_s
    wrong = predictor.predict(time_s).position_m - on_turntable(time_s).position_m
    return np.linalg.norm(wrong)


def test_turning_follows_the_circle_that_straight_lines_leave():
    assert turntable_error_m("turning", 0.1) < 2e-3
    assert turntable_error_m("kalman", 0.1) > 10e-3


def test_turning_velocity_is_tangent_to_the_circle():
    predictor = make_predictor("turning")
    for k in range(60):
        predictor.update(on_turntable(k / 30))
    prediction = predictor.predict(60 / 30 + 0.2)
    turned = 2.0 * (60 / 30 + 0.2)
    tangent = 0.5 * np.array([-math.sin(turned), math.cos(turned), 0.0])
    np.testing.assert_allclose(prediction.velocity_mps, tangent, atol=5e-3)
    assert prediction.yaw_rate_radps == pytest.approx(2.0, abs=1e-3)


def test_turning_is_the_straight_filter_where_nothing_turns():
    straight, turning = make_predictor("kalman"), make_predictor("turning")
    rng = np.random.default_rng(1)
    for k in range(30):
        seen = pose(k / 30, [0.5, 0.25 * k / 30, 0.08] + 1e-3 * rng.standard_normal(3), 0.4)
        straight.update(seen)
        turning.update(seen)
    for one, other in zip(
        vars(straight.predict(1.1)).values(), vars(turning.predict(1.1)).values(), strict=True
    ):
        np.testing.assert_allclose(one, other, atol=1e-12)


def test_latest_does_not_predict():
    predictor = make_predictor("latest")
    for k in range(5):
        predictor.update(pose(k / 30, [0.5, 0.25 * k / 30, 0.08]))
    np.testing.assert_allclose(predictor.predict(1.0).position_m[1], 0.25 * 4 / 30)
    np.testing.assert_allclose(predictor.predict(1.0).velocity_mps, 0.0)


@pytest.mark.parametrize("name", PREDICTORS)
def test_unusable_and_late_poses_are_ignored(name):
    predictor = make_predictor(name)
    predictor.update(pose(0.0, [0.5, 0.0, 0.08]))
    predictor.update(pose(0.1, [0.5, 0.01, 0.08]))
    expected = predictor.predict(0.2).position_m
    predictor.update(pose(0.2, [np.nan, 0.0, 0.08]))
    predictor.update(pose(0.2, [0.5, 0.0, 0.08], math.inf))
    predictor.update(pose(math.nan, [0.5, 9.0, 0.08]))
    predictor.update(pose(0.1, [0.5, 9.0, 0.08]))
    predictor.update(pose(0.05, [0.5, 9.0, 0.08]))
    np.testing.assert_array_equal(predictor.predict(0.2).position_m, expected)


def test_weighted_acceleration_follows_uniform_acceleration():
    predictor = make_predictor("weighted")
    for k in range(9):
        t = k / 30
        predictor.update(pose(t, [0.5, 0.5 * 2.0 * t * t, 0.08]))
    prediction = predictor.predict(8 / 30 + 1 / 30)
    acceleration = (predictor.predict(1.3).velocity_mps - predictor.predict(0.3).velocity_mps)[1]
    assert acceleration == pytest.approx(2.0, rel=1e-6)
    assert prediction.velocity_mps[1] > 0


def test_history_is_dropped_after_a_long_gap():
    for name in MOVING:
        predictor = make_predictor(name)
        for k in range(10):
            predictor.update(pose(k / 30, [0.5, k / 30, 0.08]))
        predictor.update(pose(5.0, [0.5, 0.0, 0.08]))
        np.testing.assert_allclose(predictor.predict(5.5).position_m[1], 0.0, atol=1e-9)


def test_half_turn_symmetry_unwraps_modulo_pi():
    settings = PREDICTORS["least-squares"]
    config = PredictorConfig(settings.description, settings.make, yaw_period_rad=math.pi)
    predictor = config.make(config)
    for k, yaw in enumerate([1.55, -1.57, 1.57, -1.55]):
        predictor.update(pose(k / 30, [0.5, 0.0, 0.08], yaw))
    assert predictor.predict(0.1).yaw_rad == pytest.approx(1.59, abs=0.05)


def test_kalman_smooths_noise_better_than_differences():
    rng = np.random.default_rng(0)
    errors = {name: [] for name in MOVING}
    for _ in range(30):
        predictors = {name: make_predictor(name) for name in MOVING}
        for k in range(30):
            z = np.array([0.5, 0.25 * k / 30, 0.08]) + 2e-3 * rng.standard_normal(3)
            for predictor in predictors.values():
                predictor.update(pose(k / 30, z))
        for name, predictor in predictors.items():
            error = predictor.predict(29 / 30 + 0.1).position_m[1] - 0.25 * (29 / 30 + 0.1)
            errors[name].append(error)
    rms = {name: np.sqrt(np.mean(np.square(e))) for name, e in errors.items()}
    assert rms["kalman"] < rms["weighted-velocity"] < rms["weighted"]


def test_unknown_names_list_the_valid_ones():
    with pytest.raises(ValueError, match=r"kalman.*least-squares.*oraculum"):
        make_predictor("oraculum")


@pytest.mark.parametrize(
    ("field", "value"),
    [("history_count", 1), ("acceleration_psd", (1.0, 1.0)), ("max_gap_s", math.nan)],
)
def test_bad_settings_are_refused(field, value):
    with pytest.raises(ValueError, match=field):
        PredictorConfig("", PREDICTORS["kalman"].make, **{field: value})


def batch_estimate(times_s, z, variances, psd, velocity_variance):
    """Position and velocity at the last of n times, from all n positions at once.

    The first position is the prior mean, at rest. The position is then a Gaussian process: the
    integral of a Wiener process with spectral density `psd`, and a line with random coefficients.
    """
    t = times_s[1:] - times_s[0]
    early, late = np.minimum.outer(t, t), np.maximum.outer(t, t)
    line = variances[0] + velocity_variance * np.outer(t, t)
    positions = line + psd * early**2 * (3.0 * late - early) / 6.0
    with_velocity = velocity_variance * t + psd * t**2 / 2.0
    gain = np.linalg.solve(positions + np.diag(variances[1:]), z[1:] - z[0])
    return z[0] + positions[-1] @ gain, with_velocity @ gain


def test_the_kalman_filter_is_the_batch_estimate_of_its_model():
    """A recursion with a wrong covariance has other gains, and another estimate."""
    rng = np.random.default_rng(0)
    times_s = np.cumsum(rng.uniform(0.02, 0.3, 12))
    z = np.cumsum(rng.standard_normal((12, 4)), axis=0) * [0.02, 0.02, 0.003, 0.05]
    deviations = rng.uniform(0.5, 5.0, (12, 4)) * [1e-3, 2e-3, 3e-3, 2e-2]
    predictor = make_predictor("kalman")
    for time_s, place, deviation in zip(times_s, z, deviations, strict=True):
        covariance = np.diag(deviation**2)
        predictor.update(replace(pose(time_s, place[:3], place[3]), covariance=covariance))
        if time_s == times_s[0]:
            continue
        n = int(np.searchsorted(times_s, time_s)) + 1
        found = predictor.predict(time_s)
        for axis in range(4):
            position, velocity = batch_estimate(
                times_s[:n],
                z[:n, axis],
                deviations[:n, axis] ** 2 + KalmanConstantVelocity._floor[axis],
                PREDICTORS["kalman"].acceleration_psd[axis],
                KalmanConstantVelocity._initial_velocity_variance[axis],
            )
            assert [*found.position_m, found.yaw_rad][axis] == pytest.approx(position, rel=1e-9)
            rates = [*found.velocity_mps, found.yaw_rate_radps]
            assert rates[axis] == pytest.approx(velocity, rel=1e-7, abs=1e-12)
