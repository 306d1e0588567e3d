"""What a trial remembers: truth, belief and hand at every control step, and every estimate."""

import math
from dataclasses import dataclass, field

import numpy as np

from sim.arm.grasp import Phase
from tracker.base import Status


@dataclass(frozen=True)
class ControlSample:
    """One control step."""

    time_s: float
    phase: Phase
    true_position_m: np.ndarray
    """(3,) centre of the object's top face in the world."""
    true_yaw_rad: float
    servo_error: float | None
    """Norm of the pose error that the servo believes in, [IGPF2021] Eq. (26); None untracked."""
    true_error: float
    """The same norm between the true hand and the true object."""
    is_feasible: bool


@dataclass(frozen=True)
class EstimateSample:
    """What perception made of one image."""

    time_s: float
    """Exposure."""
    position_m: np.ndarray | None
    """(3,) estimated centre of the top face; None where no usable pose came out."""
    yaw_rad: float | None
    status: Status
    ess: float | None
    visible_fraction: float | None


@dataclass
class TrialTrace:
    """Everything recorded during one trial, in order of time."""

    control: list[ControlSample] = field(default_factory=list[ControlSample])
    estimates: list[EstimateSample] = field(default_factory=list[EstimateSample])

    def first_entry_s(self, phase: Phase) -> float | None:
        """When `phase` first began, None if it never did."""
        return next((s.time_s for s in self.control if s.phase is phase), None)

    def errors_until(self, time_s: float) -> tuple[np.ndarray, np.ndarray]:
        """Errors of the usable poses whose exposure lies before `time_s`.

        Returns:
            (n,) distances [m] and (n,) yaw errors [rad] modulo half a turn, against the truth
            interpolated at each exposure.
        """
        times = np.array([s.time_s for s in self.control])
        positions = np.array([s.true_position_m for s in self.control])
        yaws = np.unwrap([s.true_yaw_rad for s in self.control])
        distances: list[float] = []
        turns: list[float] = []
        for estimate in self.estimates:
            if estimate.position_m is None or estimate.yaw_rad is None or estimate.time_s >= time_s:
                continue
            truth = [np.interp(estimate.time_s, times, positions[:, i]) for i in range(3)]
            distances.append(float(np.linalg.norm(estimate.position_m - truth)))
            yaw = float(np.interp(estimate.time_s, times, yaws))
            turns.append(math.remainder(estimate.yaw_rad - yaw, math.pi))
        return np.array(distances), np.array(turns)
