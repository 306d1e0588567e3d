"""Tables of bearing-only flights, from runs.csv and timings.csv alone."""

# pyright: basic, reportArgumentType=false, reportAttributeAccessIssue=false, reportCallIssue=false, reportGeneralTypeIssues=false
# pandas is annotated in part: what a selection or a group gives is not known.

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pandas as pd

from experiments.bearing_only.controllers import CONTROLLERS
from experiments.report.statistics import BOOTSTRAP_SAMPLES
from experiments.report.table import Column, Table, TableRow, show_number, show_rate
from experiments.seeding import Stream, generator

SETTINGS = (
    "range_prior",
    "v_max_mps",
    "target_speed_mps",
    "landmark_count",
    "iteration_count",
    "pose_error",
    "pose_error_m",
)
"""Columns that name a cell, besides the controller."""

_LABELS = {
    "range_prior": "range prior",
    "v_max_mps": "v_max [m/s]",
    "target_speed_mps": "target [m/s]",
    "landmark_count": "landmarks",
    "iteration_count": "iterations",
    "pose_error": "pose error",
    "pose_error_m": "its std [m]",
}


def varying(runs: pd.DataFrame) -> list[str]:
    """The settings that differ within the folder."""
    return [name for name in SETTINGS if runs[name].nunique() > 1]


def cells(runs: pd.DataFrame) -> Iterator[tuple[TableRow, pd.DataFrame]]:
    """Each setting with each controller: what names it, and its flights in order of seed."""
    keys = [*varying(runs), "controller"]
    for cell, members in runs.groupby(keys, sort=False):
        names = cell if isinstance(cell, tuple) else (cell,)
        yield dict(zip(keys, names, strict=True)), members.sort_values("seed")


def error_table(runs: pd.DataFrame) -> Table:
    """Errors of target and vehicle: means over the flights, their deviation and the worst flight.

    A flight that broke off has no errors; `tracked` counts those that kept the target to the end.
    The interval is of the mean, 95 %, by bootstrap over the seeds.
    """
    rows: list[TableRow] = []
    for cell, members in cells(runs):
        known = members.dropna(subset=["target_error_m"])
        row: TableRow = cell | {
            "n": len(members),
            "tracked": int((members["outcome"] == "tracked").sum()),
        }
        row |= _spread(known, "target_error_m") | _spread(known, "robot_error_m")
        for name in ("target_error_late_m", "dead_reckoning_error_m"):
            row[name] = _mean(known, name)
        row["robot_over_dead_reckoning"] = _ratio(
            row["robot_error_m_mean"], row["dead_reckoning_error_m"]
        )
        rows.append(row)
    columns = [
        *_key_columns(runs),
        Column("n", lambda row: str(row["n"])),
        Column("tracked", lambda row: str(row["tracked"])),
        Column("target [m] ± sd", lambda row: _show_spread(row, "target_error_m")),
        Column("[95 %]", lambda row: _show_interval(row, "target_error_m")),
        Column("worst", lambda row: show_number(row["target_error_m_max"])),
        Column("2nd half", lambda row: show_number(row["target_error_late_m"], 3)),
        Column("robot [m] ± sd", lambda row: _show_spread(row, "robot_error_m")),
        Column("worst", lambda row: show_number(row["robot_error_m_max"])),
        Column("dead reckoning", lambda row: show_number(row["dead_reckoning_error_m"], 3)),
        Column("ratio", lambda row: show_number(row["robot_over_dead_reckoning"])),
    ]
    return Table(tuple(rows), tuple(columns))


_CONSISTENCY = (
    ("robot_nees", np.median, "robot NEES (3)", 2),
    ("target_nees", np.median, "target NEES (3)", 2),
    ("sight_std_start_m", np.mean, "sight std first [m]", 2),
    ("sight_std_max_m", np.mean, "largest", 2),
    ("sight_std_late_m", np.mean, "2nd half", 2),
    ("switch_iteration", np.median, "switch", 0),
    ("seen_share", np.mean, "in view %", 1),
    ("distance_mean_m", np.mean, "distance [m]", 1),
    ("distance_min_m", np.min, "least", 1),
    ("aside_speed_mps", np.mean, "aside [m/s]", 2),
    ("landmarks_in_view", np.mean, "landmarks in view", 1),
)
"""Column of runs.csv, how it is summed up over the flights, heading and digits."""


def behaviour_table(runs: pd.DataFrame) -> Table:
    """Consistency (medians), what the target's range was worth, and how the vehicle moved."""
    rows: list[TableRow] = []
    for cell, members in cells(runs):
        row: TableRow = dict(cell)
        for name, function, *_ in _CONSISTENCY:
            values = members[name].dropna().to_numpy(float)
            row[name] = float(function(values)) if len(values) else None
        rows.append(row)
    columns = _key_columns(runs)
    columns += [
        Column(label, lambda row, name=name, digits=digits: _show_measure(row, name, digits))
        for name, _, label, digits in _CONSISTENCY
    ]
    return Table(tuple(rows), tuple(columns))


def _show_measure(row: TableRow, name: str, digits: int) -> str:
    value = row[name]
    if name == "seen_share" and value is not None:
        return show_rate(value)
    return show_number(value, digits)


def ratio_table(runs: pd.DataFrame, reference: str = "gradient") -> Table | None:
    """Mean target error over that of the paper's gradient on the same seeds; None without it.

    The interval is 95 %, by bootstrap over seeds in pairs.
    """
    rows: list[TableRow] = []
    keys = varying(runs)
    settings = runs.groupby(keys, sort=False) if keys else [((), runs)]
    for cell, members in settings:
        names = cell if isinstance(cell, tuple) else (cell,)
        wide = members.pivot_table("target_error_m", "seed", "controller", sort=False)
        if reference not in wide:
            continue
        for name in (c for c in CONTROLLERS if c in wide and c != reference):
            pairs = wide[[name, reference]].dropna().to_numpy(float)
            if len(pairs):
                row = dict(zip(keys, names, strict=True)) | {"controller": name}
                rows.append(row | _paired_ratio(pairs))
    if not rows:
        return None
    columns = [
        *_key_columns(runs),
        Column("pairs", lambda row: str(row["n"])),
        Column(f"error over {reference}", lambda row: show_number(row["ratio"])),
        Column("[95 %]", lambda row: f"[{show_number(row['low'])}, {show_number(row['high'])}]"),
        Column("better in", lambda row: str(row["better"])),
    ]
    return Table(tuple(rows), tuple(columns))


def _paired_ratio(pairs: np.ndarray) -> TableRow:
    n = len(pairs)
    draws = generator(0, Stream.BOOTSTRAP).integers(0, n, (BOOTSTRAP_SAMPLES, n))
    means = pairs[draws].mean(axis=1)
    low, high = np.percentile(means[:, 0] / means[:, 1], [2.5, 97.5])
    mean = pairs.mean(axis=0)
    return {
        "n": n,
        "ratio": float(mean[0] / mean[1]),
        "low": float(low),
        "high": float(high),
        "better": int((pairs[:, 0] < pairs[:, 1]).sum()),
    }


def cost_table(runs: pd.DataFrame, timings: pd.DataFrame) -> Table | None:
    """What an iteration of estimator and control cost on the machine of the flights."""
    known = runs.merge(timings, on=("run_id"), suffixes=("", "_timed"))
    known = known.dropna(subset=["step_median_ms"])
    rows: list[TableRow] = [
        {
            "controller": name,
            "landmark_count": int(count),
            "n": len(members),
            "step_median_ms": float(members["step_median_ms"].median()),
            "step_p95_ms": float(members["step_p95_ms"].median()),
            "flights_at_once": int(members["flights_at_once"].max()),
        }
        for (name, count), members in known.groupby(["controller", "landmark_count"], sort=False)
    ]
    columns = [
        Column("controller", lambda row: row["controller"]),
        Column("landmarks", lambda row: str(row["landmark_count"])),
        Column("n", lambda row: str(row["n"])),
        Column("flights at once", lambda row: str(row["flights_at_once"])),
        Column("median [ms/iteration]", lambda row: show_number(row["step_median_ms"])),
        Column("95th percentile", lambda row: show_number(row["step_p95_ms"])),
    ]
    return Table(tuple(rows), tuple(columns)) if rows else None


def _key_columns(runs: pd.DataFrame) -> list[Column]:
    columns = [
        Column(_LABELS[name], lambda row, name=name: _show_setting(row[name]))
        for name in varying(runs)
    ]
    return [*columns, Column("controller", lambda row: row["controller"])]


def _show_setting(value: object) -> str:
    return value if isinstance(value, str) else f"{value:g}"


def _spread(known: pd.DataFrame, name: str) -> TableRow:
    values = known[name].to_numpy(float)
    if not len(values):
        return dict.fromkeys(f"{name}_{key}" for key in ("mean", "std", "low", "high", "max"))
    low, high = bootstrap_mean(values)
    return {
        f"{name}_mean": float(values.mean()),
        f"{name}_std": float(values.std(ddof=1)) if len(values) > 1 else math.nan,
        f"{name}_low": low,
        f"{name}_high": high,
        f"{name}_max": float(values.max()),
    }


def bootstrap_mean(values: np.ndarray) -> tuple[float, float]:
    """95 % interval of a mean over seeds.  Source: [Efron1993], percentile interval."""
    n = len(values)
    draws = generator(0, Stream.BOOTSTRAP).integers(0, n, (BOOTSTRAP_SAMPLES, n))
    low, high = np.percentile(values[draws].mean(axis=1), [2.5, 97.5])
    return float(low), float(high)


def _mean(known: pd.DataFrame, name: str) -> float | None:
    return float(known[name].mean()) if len(known) else None


def _ratio(value: float | None, reference: float | None) -> float | None:
    return value / reference if value is not None and reference else None


def _show_spread(row: TableRow, name: str) -> str:
    mean, std = row[f"{name}_mean"], row[f"{name}_std"]
    return "-" if mean is None else f"{show_number(mean, 3)} ± {show_number(std, 3)}"


def _show_interval(row: TableRow, name: str) -> str:
    low, high = row[f"{name}_low"], row[f"{name}_high"]
    return "-" if low is None else f"[{show_number(low, 3)}, {show_number(high, 3)}]"
