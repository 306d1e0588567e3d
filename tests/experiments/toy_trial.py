"""A stand-in for `experiments.belt.trial.run_trial` that needs no simulator.

Its misbehaviour is steered by environment variables, which spawned workers inherit.
"""

from __future__ import annotations

import dataclasses
import math
import os
import random
import signal
import time
from pathlib import Path

import numpy as np

from experiments.belt.config import TrialConfig, TrialResult, TrialTimings
from experiments.belt.curves import ErrorCurve


def make_row(config: TrialConfig, preset: str = "toy", **changes: object) -> TrialResult:
    """A row whose numbers depend on the configuration alone."""
    draw = random.Random(config.trial_id)
    success = draw.random() < 0.9 - 0.5 * config.speed_mps
    values: dict[str, object] = {
        **dataclasses.asdict(config),
        "trial_id": config.trial_id,
        "preset": preset,
        "outcome": "success" if success else draw.choice(["missed", "lost_track"]),
        "success": success,
        "clean_success": success and draw.random() < 0.8,
        "criterion_met": success,
        "time_to_track_s": draw.random(),
        "time_to_sync_s": None,
        "time_to_grasp_s": 2 + draw.random() if success else None,
        "belt_used_m": draw.random(),
        "track_rmse_m": 0.002 * draw.random(),
        "track_yaw_rmse_rad": 0.02 * draw.random(),
        "close_error_m": 0.01 * draw.random(),
        "close_error_closing_axis_m": -0.01 * draw.random(),
        "close_yaw_error_rad": 1e-9 * draw.random(),
        "in_hand_slip_m": None,
        "max_tilt_rad": 0.0,
        "is_early_contact": False,
        "median_ess": 1e3 * draw.random(),
        "lost_count": draw.randrange(3),
        "visible_fraction_min": None,
        "simulated_s": 5.0,
        "detail": 'a "quoted", comma',
        "commit": "abc",
        "mujoco_version": "3",
        "gl_renderer": "toy",
    }
    return TrialResult(**(values | changes))  # pyright: ignore[reportArgumentType]


def make_curve(config: TrialConfig) -> ErrorCurve:
    """An error that falls from the belief of 0.3 m and is 2 mm larger in truth."""
    count = int(os.environ.get("TOY_CURVE_SAMPLES", "10")) + config.seed % 3
    servo_m = 0.3 * np.exp(-np.arange(count) / 5.0)
    servo_m[0] = math.nan
    return ErrorCurve(servo_m, np.nan_to_num(servo_m, nan=0.3) + 0.002)


def _is_first(variable: str) -> bool:
    """True for the first trial of all processes that gets here; the variable names a marker."""
    path = os.environ.get(variable)
    try:
        return path is not None and Path(path).touch(exist_ok=False) is None
    except FileExistsError:
        return False


def run_trial(
    config: TrialConfig, video_path: Path | None = None, *, preset: str = "trial"
) -> tuple[TrialResult, TrialTimings, str]:
    """A short trial; slow, crashing or killed where the environment says so."""
    time.sleep(float(os.environ.get("TOY_SLEEP_S", "0")))
    if _is_first("TOY_SLOW_ONCE"):
        time.sleep(float(os.environ["TOY_SLOW_S"]))
    if str(config.seed) in os.environ.get("TOY_CRASH_SEEDS", "").split(","):
        message = os.environ.get("TOY_CRASH_MESSAGE", "the toy broke,\non purpose")
        raise ZeroDivisionError(message)
    if str(config.seed) in os.environ.get("TOY_DEADLY_SEEDS", "").split(","):
        os.kill(os.getpid(), signal.SIGKILL)
    if config.seed == 1 and _is_first("TOY_KILL_ONCE"):
        os.kill(os.getpid(), signal.SIGKILL)
    row = make_row(config, preset)
    if video_path is not None:
        video_path.write_text(f"video of {config.trial_id}")
    timings = TrialTimings(
        trial_id=config.trial_id,
        wall_s=time.perf_counter() % 1.0,
        simulated_s=row.simulated_s,
        render_ms_per_image=10.0 + config.seed,
        track_ms_per_image=None,
        servo_ms_per_step=0.1,
        physics_ms_per_step=0.2,
    )
    return row, timings, make_curve(config).to_csv(config.trial_id)
