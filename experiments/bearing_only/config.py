"""What determines a flight, and the row that it leaves."""

import hashlib
import json
from dataclasses import asdict, dataclass
from typing import Literal, TypeAlias, get_args

from experiments.bearing_only.controllers import ORACLES, get_controller
from tracker.checks import require_choice, require_count, require_positive

StudyName: TypeAlias = Literal[
    "line", "circle", "speed", "localisation", "robot", "line-pixels", "circle-pixels"
]
PIXELS = "-pixels"
"""What the names of studies with rendered images end in."""
STUDY_NAMES: tuple[str, ...] = get_args(StudyName)
Outcome: TypeAlias = Literal["tracked", "lost", "diverged", "error"]
"""Followed to the end; out of view for good; the pose went astray; or the run broke off."""
PoseErrorKind: TypeAlias = Literal["none", "told", "hidden", "drift"]
"""Of the oracle's pose: no error; white noise that the filter knows of, or not; or a random walk
of the same size at the end, told."""


@dataclass(frozen=True)
class FlightRun:
    """Everything that determines one flight."""

    study: StudyName
    controller: str
    seed: int = 0
    v_max_mps: float = 2.5
    target_speed_mps: float = 2.0
    range_prior: float = 0.2
    """Standard deviation of the first guess of the range, as a share of it."""
    landmark_count: int = 100
    iteration_count: int = 500
    pose_error: PoseErrorKind = "none"
    pose_error_m: float = 0.0
    """Standard deviation of the error that is added to the oracle's position, per axis."""

    def __post_init__(self) -> None:
        require_choice(self, "study", STUDY_NAMES)
        get_controller(self.controller)
        require_positive(self, "v_max_mps", "target_speed_mps", "range_prior")
        require_count(self, "seed", "landmark_count", least=0)
        require_count(self, "iteration_count")
        require_choice(self, "pose_error", get_args(PoseErrorKind))
        if self.is_rendered and get_controller(self.controller).pose in ORACLES:
            raise ValueError(f"{self.controller} flies among points only, not in images")
        if not 0.0 <= self.pose_error_m < float("inf"):
            raise ValueError(f"pose_error_m must be 0 or greater, got {self.pose_error_m!r}")

    @property
    def is_rendered(self) -> bool:
        """Whether the vehicle sees rendered images, in place of the pixels of points."""
        return self.study.endswith(PIXELS)

    @property
    def run_id(self) -> str:
        """Hash of every field."""
        return hashlib.sha256(json.dumps(asdict(self)).encode()).hexdigest()[:12]


@dataclass(frozen=True)
class FlightResult:
    """One row of runs.csv; errors are distances in the world, means over all iterations."""

    run_id: str
    study: str
    controller: str
    seed: int
    v_max_mps: float
    target_speed_mps: float
    range_prior: float
    landmark_count: int
    iteration_count: int
    pose_error: str
    pose_error_m: float
    outcome: Outcome
    target_error_m: float | None = None
    target_error_late_m: float | None = None
    """Over the second half."""
    target_error_end_m: float | None = None
    velocity_error_late_mps: float | None = None
    robot_error_m: float | None = None
    robot_error_max_m: float | None = None
    dead_reckoning_error_m: float | None = None
    """Of the sum of the same odometry, beside whatever the controller used."""
    robot_nees: float | None = None
    """Median over the iterations after the first second; 3 degrees of freedom."""
    target_nees: float | None = None
    """Likewise, of the target's position."""
    sight_std_start_m: float | None = None
    """Standard deviation of the target along the line of sight at the first iteration."""
    sight_std_max_m: float | None = None
    sight_std_late_m: float | None = None
    """Mean over the second half."""
    switch_iteration: int | None = None
    """First iteration at which following has less than half of the speed; empty if none."""
    seen_share: float | None = None
    """Share of the iterations with the target in view."""
    distance_mean_m: float | None = None
    distance_min_m: float | None = None
    aside_speed_mps: float | None = None
    """Mean speed across the line of sight to the target."""
    landmarks_in_view: float | None = None
    """Mean over the iterations."""
    detail: str = ""
    """What broke the run off."""
    commit: str = ""


@dataclass(frozen=True)
class FlightTimings:
    """One row of timings.csv: wall-clock, apart from the results that must repeat."""

    run_id: str
    controller: str
    step_median_ms: float | None
    step_p95_ms: float | None
    flights_at_once: int
    """Of an oracle's flights all seeds of a cell fly together; the times are those of all."""
    wall_s: float
