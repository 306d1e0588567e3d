"""Error curves of made-up traces, and their file."""

import math

import numpy as np
import pytest

from experiments.belt.curves import CURVE_HEADER, CURVE_HZ, ErrorCurve, read_curves
from experiments.belt.trace import ControlSample, TrialTrace
from sim.arm.grasp import Phase

ENTERED_S = 0.25


def trace(end_s=2.0, lift_s=math.inf, known_s=0.5):
    """The servo's error is the time itself from `known_s` on, the true one 1 m more."""
    return TrialTrace(
        [
            ControlSample(
                time_s=time_s,
                phase=Phase.LIFT if time_s >= lift_s else Phase.APPROACH,
                true_position_m=np.zeros(3),
                true_yaw_rad=0.0,
                servo_error=time_s if time_s >= known_s else None,
                true_error=time_s + 1.0,
                is_feasible=True,
            )
            for time_s in np.arange(0.0, end_s, 1 / 120).tolist()
        ]
    )


def test_a_curve_begins_in_view_and_has_a_sample_each_thirtieth_of_a_second():
    curve = ErrorCurve.of(trace(), ENTERED_S)
    assert curve.time_s[:2] == pytest.approx([0.0, 1 / CURVE_HZ])
    assert curve.true_m == pytest.approx(curve.time_s + ENTERED_S + 1.0)
    known = curve.time_s + ENTERED_S >= 0.5 - 1e-9
    assert np.array_equal(np.isnan(curve.servo_m), ~known)
    assert curve.servo_m[known] == pytest.approx(curve.true_m[known] - 1.0)
    assert curve.time_s[-1] + ENTERED_S == pytest.approx(2.0, abs=1.5 / CURVE_HZ)


def test_a_curve_ends_where_the_hand_lifts():
    curve = ErrorCurve.of(trace(lift_s=1.0), ENTERED_S)
    assert curve.true_m.max() < 2.0 and len(curve.true_m) == pytest.approx(0.75 * CURVE_HZ, abs=1)


def test_what_was_never_in_view_has_no_curve():
    for curve in (ErrorCurve.of(trace(), None), ErrorCurve.of(trace(), 99.0)):
        assert len(curve.true_m) == len(curve.servo_m) == 0
        assert curve.to_csv("abc") == ""


def test_curves_come_back_from_their_lines():
    curve = ErrorCurve.of(trace(), ENTERED_S)
    curves = read_curves({(name,): curve.to_csv(name) for name in ("one", "two")})
    assert list(curves) == ["one", "two"]
    assert curves["two"].servo_m == pytest.approx(curve.servo_m, abs=1e-5, nan_ok=True)
    assert curves["two"].true_m == pytest.approx(curve.true_m, abs=1e-5)
    header = CURVE_HEADER.count(",")
    assert all(line.count(",") == header for line in curve.to_csv("one").splitlines())
