"""One trial in words, for a terminal."""

import math

from experiments.belt.config import TrialConfig, TrialResult, TrialTimings
from experiments.report.table import show_number


def summary_lines(config: TrialConfig, result: TrialResult, timings: TrialTimings) -> list[str]:
    """Returns what was tried, how it ended, how exact it was, and what it cost."""
    lines = [
        f"{config.tracker} at {config.speed_mps:g} m/s, seed {config.seed}: "
        f"{config.embodiment}, {config.camera} camera, {config.condition} condition, "
        f"{1e3 * config.delay_s:g} ms delay, {config.predictor} predictor",
        f"  outcome        {_verdict(result)}",
        f"  criterion      {'met' if result.criterion_met else 'not met'}",
    ]
    measured = [
        ("time to track", result.time_to_track_s, 1.0, 3, "s"),
        ("time to grasp", result.time_to_grasp_s, 1.0, 3, "s"),
        ("belt used", result.belt_used_m, 1.0, 3, "m"),
        ("track RMSE", result.track_rmse_m, 1e3, 2, "mm"),
        ("yaw RMSE", result.track_yaw_rmse_rad, math.degrees(1.0), 2, "deg"),
        ("close error", result.close_error_m, 1e3, 2, "mm"),
    ]
    for label, value, scale, digits, unit in measured:
        if value is not None:
            lines.append(f"  {label:<13}  {show_number(scale * value, digits)} {unit}")
    lines.append(f"  wall time      {_wall(timings)}")
    lines.append(f"  trial id       {result.trial_id}")
    return lines


def _verdict(result: TrialResult) -> str:
    detail = f" ({result.detail})" if result.detail else ""
    clean = " (clean)" if result.clean_success else ""
    return f"{result.outcome}{clean}{detail}"


def _wall(timings: TrialTimings) -> str:
    text = f"{timings.wall_s:.2f} s"
    if timings.simulated_s > 0.0 and timings.wall_s > 0.0:
        factor = timings.simulated_s / timings.wall_s
        text += f" for {timings.simulated_s:.2f} simulated s ({factor:.2g} x real time)"
    return text
