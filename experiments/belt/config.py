"""What determines a trial, and what a trial leaves behind: one flat row."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from dataclasses import dataclass
from typing import Literal

PHYSICS_HZ = 480
"""Physics steps per simulated second, as in `sim.belt.task`, which takes a second to import."""


@dataclass(frozen=True)
class TrialConfig:
    """Everything that determines one attempt to grasp a moving object."""

    tracker: str = "igpf"
    """Tracker, peer or control arm by name (`beltgrasp list`), or import path `module:Class`."""
    speed_mps: float = 0.25
    """Belt speed [m/s]."""
    embodiment: str = "ur5-rg2"
    """Arm and gripper; `beltgrasp list` names them."""
    seed: int = 0
    """World and noise seed; the same seed gives every tracker the same world."""
    camera: str = "far-side"
    """Camera view; `beltgrasp list` names them."""
    condition: str = "normal"
    """Light, sensor, surroundings: `normal`, or degradations by level, as in `dark-3+blur-1`."""
    object: str = "box"
    """Object on the belt; `beltgrasp list` names them."""
    motion: str = "constant"
    """How the belt runs, or a turntable instead; `beltgrasp list` names them."""
    predictor: str = "kalman"
    """How the target is extrapolated over the delays; `beltgrasp list` names them."""
    delay_s: float = 0.066
    """Age of an image when the tracker's answer to it is available [s]."""
    camera_rate_hz: float = 30.0
    """Exposures per second of simulated time [Hz]."""
    gripper_delay_s: float = 0.05
    """Time from the close command to the first finger motion [s]."""
    particle_count: int = 150
    """Particles of the filter; control arms ignore it."""
    error_threshold: float = 0.02
    """Pose-error norm under which the paper's criterion holds [m; radians weighted by 0.1 m]."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "condition", _in_order(self.condition))
        _require_number("speed_mps", self.speed_mps, 0.0, 3.0)
        _require_number("delay_s", self.delay_s, 0.0, 1.0)
        _require_number("gripper_delay_s", self.gripper_delay_s, 0.0, 1.0)
        _require_number("camera_rate_hz", self.camera_rate_hz, 1.0, 120.0)
        if not (PHYSICS_HZ / self.camera_rate_hz).is_integer():
            raise ValueError(
                f"camera_rate_hz must divide {PHYSICS_HZ} (as 10, 12, 15, 20, 24, 30, 40, 60 and "
                f"120 do), got {self.camera_rate_hz!r}"
            )
        _require_number("error_threshold", self.error_threshold, 1e-6, 1.0)
        if self.seed < 0:
            raise ValueError(f"seed must be 0 or greater, got {self.seed}")
        if self.particle_count < 1:
            raise ValueError(f"particle_count must be 1 or greater, got {self.particle_count}")

    @property
    def trial_id(self) -> str:
        """Hash of every field: equal ids mean equal worlds, trackers and noise."""
        canonical = json.dumps(dataclasses.asdict(self), sort_keys=True)
        return hashlib.sha256(canonical.encode()).hexdigest()[:16]


def _in_order(condition: str) -> str:
    """The one name of a condition: its parts once each, sorted, levels without leading zeros."""
    parts = (part.rpartition("-") for part in condition.split("+"))
    names = {
        f"{kind}-{int(level)}" if level.isdecimal() else kind + hyphen + level
        for kind, hyphen, level in parts
    }
    return "+".join(sorted(names))


def _require_number(field: str, value: float, low: float, high: float) -> None:
    if not (math.isfinite(value) and low <= value <= high):
        raise ValueError(f"{field} must be a number from {low:g} to {high:g}, got {value!r}")


Outcome = Literal[
    "success",
    "never_detected",
    "lost_track",
    "left_belt",
    "knocked",
    "missed",
    "slipped",
    "dropped",
    "collision",
    "infeasible_ik",
    "timeout",
    "error",
]
"""How an attempt ended: success, or the first cause of failure."""


@dataclass(frozen=True)
class TrialResult:
    """One CSV row; empty cells (None) where a trial never came to the event."""

    trial_id: str
    preset: str
    tracker: str
    embodiment: str
    camera: str
    condition: str
    object: str
    motion: str
    predictor: str
    speed_mps: float
    delay_s: float
    camera_rate_hz: float
    gripper_delay_s: float
    particle_count: int
    error_threshold: float
    seed: int
    outcome: Outcome
    success: bool
    clean_success: bool
    criterion_met: bool
    time_to_track_s: float | None
    time_to_sync_s: float | None
    time_to_grasp_s: float | None
    belt_used_m: float | None
    track_rmse_m: float | None
    track_yaw_rmse_rad: float | None
    close_error_m: float | None
    close_error_closing_axis_m: float | None
    close_yaw_error_rad: float | None
    in_hand_slip_m: float | None
    max_tilt_rad: float
    is_early_contact: bool
    median_ess: float | None
    lost_count: int
    visible_fraction_min: float | None
    simulated_s: float
    detail: str
    commit: str
    mujoco_version: str
    gl_renderer: str


@dataclass(frozen=True)
class TrialTimings:
    """Wall-clock costs of one trial; kept apart because they differ from run to run."""

    trial_id: str
    wall_s: float
    simulated_s: float
    render_ms_per_image: float | None
    track_ms_per_image: float | None
    servo_ms_per_step: float
    physics_ms_per_step: float
