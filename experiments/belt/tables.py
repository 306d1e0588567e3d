"""Tables rebuilt from the rows of trials.csv and timings.csv and nothing else."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any, get_args

import numpy as np

from experiments.belt.config import Outcome, TrialResult, TrialTimings
from experiments.report.grouping import cell_keys, group_by, heading, show_key
from experiments.report.statistics import wilson_interval
from experiments.report.table import Column, Table, TableRow, show_number, show_rate

ORACLE = "oracle"
"""The control arm whose failures are nobody's tracking."""


def success_table(results: Sequence[TrialResult]) -> Table:
    """Success rates with Wilson 95 % intervals, and how fast and how exact the arm was.

    The criterion is the paper's own, an error that the servo believes in; the gap is how many
    points it is above the success that physics grants. A trial that crashed counts as a failure.
    Time to grasp is the mean over successes; tracking
    and grip errors are medians over the trials that have them.
    """
    keys = cell_keys(results)
    rows = [
        dict(zip(keys, cell, strict=True)) | _measures(members)
        for cell, members in group_by(results, keys).items()
    ]
    columns = (
        *key_columns(keys),
        Column("n", lambda row: str(row["n"])),
        Column(
            "success % [95 %]",
            lambda row: (
                f"{show_rate(row['success_rate'])} "
                f"[{show_rate(row['success_low'])}, {show_rate(row['success_high'])}]"
            ),
        ),
        Column("clean %", lambda row: show_rate(row["clean_rate"])),
        Column("criterion %", lambda row: show_rate(row["criterion_rate"])),
        Column("gap [points]", lambda row: f"{100 * row['criterion_gap']:+.1f}"),
        Column("grasp [s]", lambda row: show_number(row["mean_time_to_grasp_s"])),
        Column("RMSE [mm]", lambda row: show_number(row["median_track_rmse_mm"])),
        Column("yaw [deg]", lambda row: show_number(row["median_track_yaw_rmse_deg"])),
        Column("grip [mm]", lambda row: show_number(row["median_close_error_mm"])),
    )
    return Table(tuple(rows), columns)


def _measures(members: Sequence[TrialResult]) -> TableRow:
    n, success_count = len(members), sum(row.success for row in members)
    low, high = wilson_interval(success_count, n)
    return {
        "n": n,
        "success_count": success_count,
        "success_rate": success_count / n,
        "success_low": low,
        "success_high": high,
        "clean_rate": sum(row.clean_success for row in members) / n,
        "criterion_rate": sum(row.criterion_met for row in members) / n,
        "criterion_gap": sum(row.criterion_met - row.success for row in members) / n,
        "mean_time_to_grasp_s": _reduce(
            np.mean, (row.time_to_grasp_s for row in members if row.success)
        ),
        "median_track_rmse_mm": _reduce(np.median, (row.track_rmse_m for row in members), 1e3),
        "median_track_yaw_rmse_deg": _reduce(
            np.median, (row.track_yaw_rmse_rad for row in members), math.degrees(1.0)
        ),
        "median_close_error_mm": _reduce(np.median, (row.close_error_m for row in members), 1e3),
    }


def _reduce(
    function: Callable[[list[float]], Any], values: Iterable[float | None], scale: float = 1.0
) -> float | None:
    """`function` of the values that exist, scaled; None where none does."""
    known = [value for value in values if value is not None]
    return scale * float(function(known)) if known else None


def key_columns(keys: Sequence[str]) -> list[Column]:
    """The columns that name a cell."""
    return [Column(heading(key), lambda row, key=key: show_key(row[key])) for key in keys]


def _number_columns(shown: Iterable[tuple[str, str, int]]) -> list[Column]:
    return [
        Column(label, lambda row, key=key, digits=digits: show_number(row[key], digits))
        for key, label, digits in shown
    ]


_TRACKING = (
    ("time_to_track_s", "to track [s]", 2),
    ("time_to_sync_s", "to sync [s]", 2),
    ("time_to_grasp_s", "to grasp [s]", 2),
    ("belt_used_m", "belt used [m]", 2),
    ("median_ess", "ESS", 1),
    ("visible_fraction_min", "least visible", 2),
)
"""Column of trials.csv whose median is shown, its heading and its digits."""


def tracking_table(results: Sequence[TrialResult]) -> Table:
    """How soon the object was tracked and grasped, how well the filter was off, what it lost.

    Medians over the trials that came to the event, times from the object's full view; `lost` is
    how often a track turned to lost in all trials of the cell, `in trials` in how many of them.
    """
    keys = cell_keys(results)
    rows: list[TableRow] = []
    for cell, members in group_by(results, keys).items():
        row: TableRow = dict(zip(keys, cell, strict=True)) | {"n": len(members)}
        for name, *_ in _TRACKING:
            values = [getattr(member, name) for member in members]
            row[name] = _reduce(np.median, values)
            row[f"{name}_n"] = sum(value is not None for value in values)
        row["lost_count"] = sum(member.lost_count for member in members)
        row["loser_count"] = sum(member.lost_count > 0 for member in members)
        rows.append(row)
    columns = [*key_columns(keys), Column("n", lambda row: str(row["n"]))]
    columns += _number_columns(_TRACKING)
    columns.append(Column("lost", lambda row: str(row["lost_count"])))
    columns.append(Column("in trials", lambda row: str(row["loser_count"])))
    return Table(tuple(rows), tuple(columns))


_COSTS = (
    ("render_ms_per_image", "render [ms/image]", 1),
    ("track_ms_per_image", "track [ms/image]", 1),
    ("servo_ms_per_step", "servo [ms/step]", 2),
    ("physics_ms_per_step", "physics [ms/step]", 2),
    ("wall_s", "trial [s]", 1),
)
"""Column of timings.csv whose median is shown, its heading and its digits."""


def cost_table(results: Sequence[TrialResult], timings: Sequence[TrialTimings]) -> Table | None:
    """What each stage cost on the machine of the sweep; None without a measured trial.

    Medians over the trials that did not crash; the real-time factor is that of all together.
    """
    cost_of = {row.trial_id: row for row in timings}
    keys = cell_keys(results)
    rows: list[TableRow] = []
    for cell, members in group_by(results, keys).items():
        known = [m for m in members if m.outcome != "error" and m.trial_id in cost_of]
        costs = [cost_of[member.trial_id] for member in known]
        if not costs:
            continue
        row: TableRow = dict(zip(keys, cell, strict=True)) | {"n": len(costs)}
        for name, *_ in _COSTS:
            row[name] = _reduce(np.median, (getattr(cost, name) for cost in costs))
        row["real_time_factor"] = sum(c.simulated_s for c in costs) / sum(c.wall_s for c in costs)
        rows.append(row)
    columns = [*key_columns(keys), Column("n", lambda row: str(row["n"]))]
    columns += _number_columns(_COSTS)
    columns.append(Column("x real time", lambda row: show_number(row["real_time_factor"])))
    return Table(tuple(rows), tuple(columns)) if rows else None


def outcome_table(results: Sequence[TrialResult]) -> Table:
    """How the trials of each cell ended: one column for each outcome that occurred."""
    keys = cell_keys(results)
    present = {row.outcome for row in results}
    outcomes: list[str] = [outcome for outcome in get_args(Outcome) if outcome in present]
    rows: list[TableRow] = []
    for cell, members in group_by(results, keys).items():
        counts = Counter(row.outcome for row in members)
        row: TableRow = dict(zip(keys, cell, strict=True)) | {"n": len(members)}
        rows.append(row | {outcome: counts[outcome] for outcome in outcomes})
    counted = [Column(name, lambda row, name=name: str(row[name])) for name in ("n", *outcomes)]
    return Table(tuple(rows), (*key_columns(keys), *counted))


def blame_table(results: Sequence[TrialResult]) -> Table | None:
    """Failures by whose they are; None without failures or without the oracle's trials.

    What the oracle grasps in the same world was there to be grasped, so the failure is one of
    tracking; what it does not is out of the arm's reach or time. The oracle sees no images, so
    its trials count for every camera, condition, predictor and delay.
    """
    graspable = {_belt_world(r): r.success for r in results if r.tracker == ORACLE}
    keys = cell_keys(results)
    rows: list[TableRow] = []
    for cell, members in group_by(results, keys).items():
        failures = [graspable.get(_belt_world(r)) for r in members if not r.success]
        if cell[0] == ORACLE or not failures or not graspable:
            continue
        counts = Counter(failures)
        row: TableRow = dict(zip(keys, cell, strict=True)) | {"n": len(members)}
        shares = {"tracking": counts[True], "arm": counts[False], "unknown": counts[None]}
        rows.append(row | {"failures": len(failures)} | shares)
    shown = ("n", "failures", "tracking", "arm", "unknown")
    columns = [Column(name, lambda row, name=name: str(row[name])) for name in shown]
    return Table(tuple(rows), (*key_columns(keys), *columns)) if rows else None


def _belt_world(row: TrialResult) -> tuple[Any, ...]:
    """What the oracle meets: the arm and its gripper, the object, the belt and the seed."""
    return (
        row.embodiment,
        row.object,
        row.motion,
        row.speed_mps,
        row.gripper_delay_s,
        row.seed,
    )
