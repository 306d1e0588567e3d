"""Error curves: how far the hand is from its grasp on the object, in belief and in truth.

The paper draws the pose error that its servo computes ([IGPF2021] Eq. 26, Figs. 13 and 14), and
calls an attempt a success when that falls below a threshold. The servo's error is one to its own
estimate, so a wrong or a late estimate does not show in it. Beside it stands the same error
between the true hand and the true object; where the two part, the tracker was wrong.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np

from experiments.belt.trace import TrialTrace
from experiments.study.study import Key
from sim.arm.grasp import Phase

CURVE_HZ = 30
"""Samples per second of simulated time."""

CURVES = "curves"
"""Name of the file of error curves."""
CURVE_HEADER = "trial_id,time_s,servo_error_m,true_error_m\n"


@dataclass(frozen=True, eq=False)
class ErrorCurve:
    """Errors from the moment the whole object is in view until the hand lifts, or the end.

    Sample k belongs to `k / CURVE_HZ` seconds after that moment. In both errors a radian counts
    as 0.1 m (`sim.arm.motion.servo_error`). While the hand hovers it keeps its distance: the
    error is then that height, not zero.
    """

    servo_m: np.ndarray
    """(n,) error that the servo believes in [m]; NaN while it knows of no target."""
    true_m: np.ndarray
    """(n,) the same between the true hand and the true object [m]."""

    @property
    def time_s(self) -> np.ndarray:
        """(n,) since the whole object was in view."""
        return np.arange(len(self.true_m)) / CURVE_HZ

    @classmethod
    def of(cls, trace: TrialTrace, entered_view_s: float | None) -> Self:
        """The curve of a trial; empty where the object never came into view."""
        if entered_view_s is None:
            return cls(np.empty(0), np.empty(0))
        lift_s = trace.first_entry_s(Phase.LIFT)
        seen = [
            sample
            for sample in trace.control
            if sample.time_s >= entered_view_s and (lift_s is None or sample.time_s < lift_s)
        ]
        servo_m = [math.nan if s.servo_error is None else s.servo_error for s in seen]
        times = np.array([s.time_s for s in seen]) - entered_view_s
        count = math.floor(times[-1] * CURVE_HZ + 1e-6) + 1 if seen else 0
        chosen = np.searchsorted(times, np.arange(count) / CURVE_HZ - 1e-6)
        return cls(np.array(servo_m)[chosen], np.array([s.true_error for s in seen])[chosen])

    def to_csv(self, trial_id: str) -> str:
        """A line for each sample, to 0.01 mm; an empty cell where the servo knew of no target."""
        rows = zip(self.time_s, self.servo_m, self.true_m, strict=True)
        return "".join(
            f"{trial_id},{time:.4f},{'' if math.isnan(servo) else f'{servo:.5f}'},{true:.5f}\n"
            for time, servo, true in rows
        )


def read_curves(lines: Mapping[Key, str]) -> dict[str, ErrorCurve]:
    """Curves by trial id, of the lines that a results folder keeps of each trial."""
    curves: dict[str, ErrorCurve] = {}
    for (trial_id,), text in lines.items():
        cells = [line.split(",")[2:] for line in text.splitlines()]
        values = np.array([[float(cell or "nan") for cell in row] for row in cells])
        curves[trial_id] = ErrorCurve(values[:, 0], values[:, 1])
    return curves
