"""What a flight leaves beside its row: error curves of all, and everything of a few to look at."""

import io
from pathlib import Path

import numpy as np
import pandas as pd

from experiments.bearing_only.config import FlightResult, FlightRun
from experiments.bearing_only.flying import FlightLog, Flown
from experiments.report.table import csv_line
from tracker.bearing_only.slam import MonocularSlam

TRACES = "traces"
"""Folder of the flights that are kept whole."""
CURVES = "curves"
"""Name of the file of error curves."""
CURVE_EVERY = 10
"""Iterations between two samples of a curve."""
CURVE_HEADER = (
    "run_id,iteration,target_error_m,robot_error_m,dead_reckoning_error_m,sight_std_m,"
    "innovation_area_px2\n"
)
CURVE_STUDIES = ("line", "circle", "robot", "line-pixels", "circle-pixels")
TRACED = ("gradient", "follow", "turn")
"""Controllers of which the flight with seed 0 is kept whole, for the figures."""
TRACED_SEED = 0
_PLACES = ("robot", "robot_estimate", "reckoned", "target", "target_estimate")


def curve_of(run: FlightRun, log: FlightLog, index: int) -> str:
    """Returns the curve of one flight as lines of CSV; empty for a study that draws none."""
    if run.study not in CURVE_STUDIES or not log:
        return ""
    errors = [
        np.linalg.norm(log.array(a)[:, index] - log.array(b)[:, index], axis=-1)
        for a, b in (
            ("target_estimate_m", "target_m"),
            ("robot_estimate_m", "robot_m"),
            ("reckoned_m", "robot_m"),
        )
    ]
    other = [log.array(name)[:, index] for name in ("sight_std_m", "innovation_area_px2")]
    return "".join(
        csv_line([run.run_id, k, *(_rounded(values[k]) for values in (*errors, *other))])
        for k in range(0, len(log), CURVE_EVERY)
    )


def is_traced(run: FlightRun) -> bool:
    """Reports whether the whole flight is kept."""
    return run.study in CURVE_STUDIES and run.controller in TRACED and run.seed == TRACED_SEED


def trace_name(run: FlightRun | FlightResult) -> str:
    """Returns the name of the files of a flight that is kept."""
    return f"{run.controller}_prior{run.range_prior:g}_v{run.v_max_mps:g}"


def trace_of(log: FlightLog, index: int) -> str:
    """Returns the whole flight as CSV."""
    columns: dict[str, np.ndarray] = {}
    for name, unit in (*((name, "m") for name in _PLACES), ("command", "mps"), ("aside", "mps")):
        for axis, values in zip("xyz", log.array(f"{name}_{unit}")[:, index].T, strict=True):
            columns[f"{name}_{axis}_{unit}"] = values
    columns |= _horizontal("target_covariance", log.array("target_covariance")[:, index])
    for name in ("follow_mps", "sight_std_m", "innovation_area_px2", "is_seen"):
        columns[name] = log.array(name)[:, index]
    return _csv(columns)


def map_of(flown: Flown) -> str | None:
    """Returns the landmarks at the end, true and estimated, as CSV; None without a map.

    Of corners in images the truth is not known, and their places are empty.
    """
    if not isinstance(flown.source, MonocularSlam):
        return None
    ids, points, P = flown.source.landmarks()
    known = flown.flight.landmarks_m
    truth = known[ids] if len(known) else np.full_like(points, np.nan)
    columns: dict[str, np.ndarray] = {"id": ids}
    for axis, true, estimate in zip("xyz", truth.T, points.T, strict=True):
        columns[f"{axis}_m"], columns[f"estimate_{axis}_m"] = true, estimate
    return _csv(columns | _horizontal("covariance", P))


def _horizontal(name: str, P: np.ndarray) -> dict[str, np.ndarray]:
    """Columns of the covariances of x and y."""
    return {f"{name}_xx_m2": P[:, 0, 0], f"{name}_xy_m2": P[:, 0, 1], f"{name}_yy_m2": P[:, 1, 1]}


def read_table(path: Path) -> dict[str, np.ndarray]:
    """The columns of a CSV file; none where there is no file."""
    return parse_table(path.read_text(encoding="utf-8")) if path.exists() else {}


def parse_table(text: str) -> dict[str, np.ndarray]:
    """The columns of a CSV, each as one array."""
    table = pd.read_csv(io.StringIO(text))
    return {str(name): np.asarray(column) for name, column in table.items()}


def _rounded(value: float) -> float:
    return float(f"{value:.4g}")


def _csv(columns: dict[str, np.ndarray]) -> str:
    frame = pd.DataFrame(columns)
    return frame.to_csv(index=False, float_format="%.5g", lineterminator="\n")
