"""What determines a trial, and what a trial leaves behind: one flat row."""

import dataclasses
import hashlib
import json
from dataclasses import dataclass
from typing import Literal

from sim.checks import require_at_least, require_within
from sim.world_config import WorldConfig


@dataclass(frozen=True)
class TrialConfig(WorldConfig):
    """Everything that determines one attempt to grasp a moving object."""

    tracker: str = "igpf"
    """Tracker, peer or control arm by name (`beltgrasp list`), or import path `module:Class`."""
    seed: int = 0
    """World and noise seed; the same seed gives every tracker the same world."""
    predictor: str = "kalman"
    """How the target is extrapolated over the delays; `beltgrasp list` names them."""
    particle_count: int = 150
    """Particles of the filter; control arms ignore it."""
    error_threshold: float = 0.02
    """Pose-error norm under which the paper's criterion holds [m; radians weighted by 0.1 m]."""

    def __post_init__(self) -> None:
        super().__post_init__()
        require_within(self, 1e-6, 1.0, "error_threshold")
        require_at_least(self, 0, "seed")
        require_at_least(self, 1, "particle_count")

    @property
    def trial_id(self) -> str:
        """Hash of every field: equal ids mean equal worlds, trackers and noise."""
        canonical = json.dumps(dataclasses.asdict(self), sort_keys=True)
        return hashlib.sha256(canonical.encode()).hexdigest()[:16]


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
