"""The five studies: which world each has, and which runs."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from experiments.bearing_only.config import FlightRun
from sim.bearing_only.flight import FlightCamera, FlightConfig, TargetPath

SPEEDS_MPS = (1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 5.0)
POSE_ERRORS_M = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""The ten of [Wu2022] Fig. 18; the text tells the last only."""


@dataclass(frozen=True)
class FlightStudy:
    """What a study of flights asks, and which controllers take part."""

    description: str
    base: FlightRun
    controllers: tuple[str, ...]
    variations: tuple[dict[str, Any], ...] = ({},)
    equilibrium_m: float = 10.0

    def runs(
        self,
        seeds: Sequence[int],
        controllers: Sequence[str] = (),
        changes: Mapping[str, Any] | None = None,
    ) -> list[FlightRun]:
        """All runs by variation, controller and seed, with other values of some fields."""
        runs = [
            replace(self.base, **variation | dict(changes or {}), controller=controller, seed=seed)
            for variation in self.variations
            for controller in (controllers or self.controllers)
            for seed in seeds
        ]
        return list(dict.fromkeys(runs))


STUDIES: dict[str, FlightStudy] = {
    "line": FlightStudy(
        "[Wu2022] section 6.2.1: a target comes head-on, with a good and with a rough range prior",
        FlightRun("line", "gradient", iteration_count=300),
        ("published", "gradient", "gradient-floor", "log-det", "turn", "follow", "random",
         "dead-reckoning", "known-pose", "known-pose-log-det", "known-pose-mixture",
         "known-pose-turn"),
        ({"range_prior": 0.03}, {"range_prior": 0.2}),
    ),
    "circle": FlightStudy(
        "[Wu2022] section 6.2.2: a target flies a circle",
        FlightRun("circle", "gradient"),
        ("published", "gradient", "log-det", "mixture", "turn", "follow", "random",
         "dead-reckoning", "known-pose-published", "known-pose", "known-pose-log-det",
         "known-pose-cubature", "known-pose-mixture", "known-pose-turn"),
    ),
    "speed": FlightStudy(
        "[Wu2022] Fig. 19: the circle at several speeds of the vehicle",
        FlightRun("speed", "gradient"),
        ("gradient", "known-pose", "known-pose-turn"),
        tuple({"v_max_mps": speed} for speed in SPEEDS_MPS),
    ),
    "localisation": FlightStudy(
        "[Wu2022] Fig. 18: the circle with noise on the known position",
        FlightRun("localisation", "known-pose", v_max_mps=3.5, landmark_count=0),
        ("known-pose-published", "known-pose", "known-pose-turn", "fused-pose"),
        tuple(
            {"pose_error": kind, "pose_error_m": std}
            for kind in ("told", "hidden", "drift")
            for std in POSE_ERRORS_M
        ),
    ),
    "line-pixels": FlightStudy(
        "the line from rendered images",
        FlightRun("line-pixels", "gradient", iteration_count=300, landmark_count=0),
        ("gradient", "log-det", "turn", "follow"),
    ),
    "circle-pixels": FlightStudy(
        "the circle from rendered images",
        FlightRun("circle-pixels", "gradient", landmark_count=0),
        ("gradient", "log-det", "turn", "follow"),
    ),
    "robot": FlightStudy(
        "[Wu2022] section 6.2.4: the indoor robot on two wheels",
        FlightRun(
            "robot", "gradient", v_max_mps=0.2, target_speed_mps=0.07, iteration_count=600
        ),
        ("gradient", "follow", "random", "dead-reckoning", "known-pose"),
        equilibrium_m=1.0,
    ),
}  # fmt: skip
"""Every study by name."""


def world_of(run: FlightRun) -> FlightConfig:
    """The world of a run.

    [Wu2022] leaves open the direction of the straight target, the circle's centre and the number
    of landmarks. Only a target that comes head-on makes the switch at iteration 85 that the text
    tells; the circle is closed in 500 steps, through the start, and lies on the room's side of it.
    """
    speed = run.target_speed_mps
    common: dict[str, Any] = {
        "iteration_count": run.iteration_count,
        "landmark_count": 0 if run.is_rendered else run.landmark_count,
    }
    if run.study in ("line", "line-pixels"):
        path = TargetPath("line", (15.0, 15.0, 1.0), (0.0, -speed, 0.0))
        return FlightConfig(path, (15.0, -15.0, 1.0), math.pi / 2, **common)
    if run.study == "robot":
        return _indoors(run)
    path = TargetPath("circle", (0.0, 15.0, 1.0), (-speed, 0.0, 0.0))
    return FlightConfig(path, (10.0, 15.0, 1.0), math.pi, **common)


def _indoors(run: FlightRun) -> FlightConfig:
    """A room of 10 m by 10 m for the robot; start and speeds are those of the text.

    The direction of the target, the room, the camera's narrow view, the time step and the wheel
    odometry's noise are assumptions: the text has none of them.
    """
    return FlightConfig(
        target=TargetPath("line", (0.0, -2.0, 0.3), (0.0, run.target_speed_mps, 0.0)),
        start_m=(2.0, -4.0, 0.3),
        yaw_rad=3.0 * math.pi / 4.0,
        iteration_count=run.iteration_count,
        dt_s=0.1,
        landmark_count=run.landmark_count,
        landmark_low_m=(-5.0, -5.0, 0.0),
        landmark_high_m=(5.0, 5.0, 2.5),
        camera=FlightCamera(s_u_px=525.0, s_v_px=525.0),
        odometry_std_m=0.001,
        odometry_std_rad=math.radians(0.05),
        is_planar=True,
    )
