"""A stand-in for `experiments.belt.trial.run_trial` that needs no simulator."""

from __future__ import annotations

import dataclasses
import math
import random
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from toy_study import disturb

from experiments.belt.config import TrialConfig, TrialResult, TrialTimings
from experiments.belt.curves import CURVES, ErrorCurve
from experiments.belt.study import SweepTrial
from experiments.study.study import Result


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


def trials_of(cells: Sequence[TrialConfig], seeds: Sequence[int]) -> list[TrialConfig]:
    """Every cell at every seed, in the order of the rows of a sweep."""
    return [dataclasses.replace(cell, seed=seed) for seed in seeds for cell in cells]


def make_curve(config: TrialConfig) -> ErrorCurve:
    """An error that falls from the belief of 0.3 m and is 2 mm larger in truth."""
    count = 10 + config.seed % 3
    servo_m = 0.3 * np.exp(-np.arange(count) / 5.0)
    servo_m[0] = math.nan
    return ErrorCurve(servo_m, np.nan_to_num(servo_m, nan=0.3) + 0.002)


def run_trial(
    config: TrialConfig, video_path: Path | None = None, *, preset: str = "trial"
) -> Result[TrialResult]:
    """A short trial, which `toy_study.disturb` may break."""
    disturb(config)
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
    return Result((row,), timings, {CURVES: make_curve(config).to_csv(config.trial_id)})


def run_trials(jobs: Sequence[SweepTrial]) -> list[Result[TrialResult]]:
    """The work of a sweep, by toy trials."""
    return [run_trial(job.config, job.video_path, preset=job.preset) for job in jobs]


def film_trial(job: SweepTrial, path: Path) -> str:
    """The film of a toy trial."""
    return run_trial(job.config, path, preset=job.preset).rows[0].outcome
