"""Tables of bearing-only flights, from runs.csv and timings.csv alone."""

import math
from collections.abc import Sequence

import numpy as np

from experiments.bearing_only.config import FlightResult, FlightTimings
from experiments.bearing_only.controllers import CONTROLLERS
from experiments.report.grouping import group_by, named_groups, varying
from experiments.report.statistics import bootstrap, mean, mean_ratio, of_known
from experiments.report.table import (
    Column,
    Table,
    TableRow,
    interval,
    number,
    show_number,
    word,
    words,
)
from experiments.seeding import Stream, generator

SETTINGS = {
    "range_prior": "range prior",
    "v_max_mps": "v_max [m/s]",
    "target_speed_mps": "target [m/s]",
    "landmark_count": "landmarks",
    "iteration_count": "iterations",
    "pose_error": "pose error",
    "pose_error_m": "its std [m]",
}
"""Columns that name a cell besides the controller where they vary, and their headings."""


def error_table(runs: Sequence[FlightResult]) -> Table:
    """Returns errors of target and vehicle: means over the flights, deviation, worst flight.

    A flight that broke off has no errors; `tracked` counts those that kept the target to the end.
    The interval is of the mean, 95 %, by bootstrap over the seeds.
    """
    rows: list[TableRow] = []
    for names, members in _cells(runs):
        known = [run for run in members if run.target_error_m is not None]
        tracked = sum(run.outcome == "tracked" for run in members)
        row = names | {"n": len(members), "tracked": tracked}
        row |= _spread(known, "target_error_m") | _spread(known, "robot_error_m")
        for name in ("target_error_late_m", "dead_reckoning_error_m"):
            row[name] = of_known(np.mean, column_of(known, name))
        error, reckoned = row["robot_error_m_mean"], row["dead_reckoning_error_m"]
        row["robot_over_dead_reckoning"] = error / reckoned if reckoned else None
        rows.append(row)
    return Table.of(
        rows,
        *_key_columns(runs),
        *words("n", "tracked"),
        _mean_and_std("target [m] ± sd", "target_error_m"),
        interval("[95 %]", "target_error_m_low", "target_error_m_high", digits=3),
        number("worst", "target_error_m_max"),
        number("2nd half", "target_error_late_m", 3),
        _mean_and_std("robot [m] ± sd", "robot_error_m"),
        number("worst", "robot_error_m_max"),
        number("dead reckoning", "dead_reckoning_error_m", 3),
        number("ratio", "robot_over_dead_reckoning"),
    )


_BEHAVIOUR = (
    ("robot_nees", np.median, "robot NEES (3)", 2, 1.0),
    ("target_nees", np.median, "target NEES (3)", 2, 1.0),
    ("sight_std_start_m", np.mean, "sight std first [m]", 2, 1.0),
    ("sight_std_max_m", np.mean, "largest", 2, 1.0),
    ("sight_std_late_m", np.mean, "2nd half", 2, 1.0),
    ("switch_iteration", np.median, "switch", 0, 1.0),
    ("seen_share", np.mean, "in view %", 1, 100.0),
    ("distance_mean_m", np.mean, "distance [m]", 1, 1.0),
    ("distance_min_m", np.min, "least", 1, 1.0),
    ("aside_speed_mps", np.mean, "aside [m/s]", 2, 1.0),
    ("landmarks_in_view", np.mean, "landmarks in view", 1, 1.0),
)
"""Column of runs.csv, how it is summed up over the flights, heading, digits, factor for people."""


def behaviour_table(runs: Sequence[FlightResult]) -> Table:
    """Returns consistency (medians), what the target's range was worth, how the vehicle moved."""
    rows = [
        names
        | {name: of_known(function, column_of(own, name)) for name, function, *_ in _BEHAVIOUR}
        for names, own in _cells(runs)
    ]
    shown = [number(label, name, digits, factor) for name, _, label, digits, factor in _BEHAVIOUR]
    return Table.of(rows, *_key_columns(runs), *shown)


def ratio_table(runs: Sequence[FlightResult], reference: str = "gradient") -> Table:
    """Returns the mean target error over that of the paper's gradient on the same seeds.

    The interval is 95 %, by bootstrap over seeds in pairs; no rows without the gradient.
    """
    rows: list[TableRow] = []
    for names, members in named_groups(runs, varying(runs, SETTINGS)):
        errors = {
            name: {run.seed: run.target_error_m for run in own if run.target_error_m is not None}
            for (name,), own in group_by(members, ["controller"]).items()
        }
        of_reference = errors.pop(reference, {})
        for name in (name for name in CONTROLLERS if name in errors):
            seeds = sorted(errors[name].keys() & of_reference.keys())
            if seeds:
                pair = [[of_one[seed] for seed in seeds] for of_one in (errors[name], of_reference)]
                found = bootstrap(mean_ratio, generator(0, Stream.BOOTSTRAP), *pair)
                row = names | {"controller": name, "n": len(seeds)}
                row |= dict(zip(("ratio", "low", "high"), found, strict=True))
                rows.append(row | {"better": sum(a < b for a, b in zip(*pair, strict=True))})
    return Table.of(
        rows,
        *_key_columns(runs),
        word("pairs", "n"),
        number(f"error over {reference}", "ratio"),
        interval("[95 %]", "low", "high"),
        word("better in", "better"),
    )


def cost_table(runs: Sequence[FlightResult], timings: Sequence[FlightTimings]) -> Table:
    """Returns what an iteration of estimator and control cost on the machine of the flights."""
    cost_of = {row.run_id: row for row in timings if math.isfinite(row.step_median_ms or math.nan)}
    known = [run for run in runs if run.run_id in cost_of]
    rows: list[TableRow] = []
    for names, members in named_groups(known, ("controller", "landmark_count")):
        costs = [cost_of[run.run_id] for run in members]
        row = names | {"n": len(members)}
        for name in ("step_median_ms", "step_p95_ms"):
            row[name] = of_known(np.median, (getattr(cost, name) for cost in costs))
        rows.append(row | {"flights_at_once": max(cost.flights_at_once for cost in costs)})
    return Table.of(
        rows,
        *words("controller"),
        word("landmarks", "landmark_count"),
        *words("n"),
        word("flights at once", "flights_at_once"),
        number("median [ms/iteration]", "step_median_ms"),
        number("95th percentile", "step_p95_ms"),
    )


def _cells(runs: Sequence[FlightResult]) -> list[tuple[TableRow, list[FlightResult]]]:
    """Groups flights by setting and controller: what names a cell, its flights in order of seed."""
    groups = named_groups(runs, [*varying(runs, SETTINGS), "controller"])
    return [(names, sorted(members, key=lambda run: run.seed)) for names, members in groups]


def _key_columns(runs: Sequence[FlightResult]) -> list[Column]:
    settings = [
        Column(SETTINGS[name], lambda row, name=name: _show_setting(row[name]))
        for name in varying(runs, SETTINGS)
    ]
    return [*settings, *words("controller")]


def _show_setting(value: str | float) -> str:
    return value if isinstance(value, str) else f"{value:g}"


def column_of(runs: Sequence[FlightResult], name: str) -> np.ndarray:
    """Returns the numbers of a column of runs.csv, without empty cells."""
    values: list[float | None] = [getattr(run, name) for run in runs]
    return np.array([value for value in values if value is not None], float)


def _spread(known: Sequence[FlightResult], name: str) -> TableRow:
    values = column_of(known, name)
    if not len(values):
        return dict.fromkeys(f"{name}_{key}" for key in ("mean", "std", "low", "high", "max"))
    middle, low, high = bootstrap(mean, generator(0, Stream.BOOTSTRAP), values)
    return {
        f"{name}_mean": middle,
        f"{name}_std": float(values.std(ddof=1)) if len(values) > 1 else math.nan,
        f"{name}_low": low,
        f"{name}_high": high,
        f"{name}_max": float(values.max()),
    }


def _mean_and_std(label: str, name: str) -> Column:
    def show(row: TableRow) -> str:
        mean, std = row[f"{name}_mean"], row[f"{name}_std"]
        return "-" if mean is None else f"{show_number(mean, 3)} ± {show_number(std, 3)}"

    return Column(label, show)
