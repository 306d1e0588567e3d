"""Tables with a row for each cell, from the rows of trials.csv and timings.csv and nothing else."""

import math
from collections import Counter
from collections.abc import Sequence
from typing import Any, get_args

import numpy as np

from experiments.belt.analysis.cells import cell_keys, key_columns
from experiments.belt.config import Outcome, TrialResult, TrialTimings
from experiments.report.grouping import named_groups
from experiments.report.statistics import of_known, wilson_interval
from experiments.report.table import Column, Table, TableRow, interval, number, numbers, rate, words

ORACLE = "oracle"
"""The control arm whose failures are nobody's tracking."""


def success_table(results: Sequence[TrialResult]) -> Table:
    """Returns success rates with Wilson 95 % intervals, and how fast and how exact the arm was.

    The criterion is the paper's own, an error that the servo believes in; the gap is how many
    points it is above the success that physics grants. A trial that crashed counts as a failure.
    Time to grasp is the mean over successes; tracking and grip errors are medians over the trials
    that have them.
    """
    keys = cell_keys(results)
    columns = (
        *key_columns(keys),
        *words("n"),
        interval(
            "success % [95 %]",
            "success_rate",
            "success_low",
            "success_high",
            digits=1,
            factor=100.0,
        ),
        rate("clean %", "clean_rate"),
        rate("criterion %", "criterion_rate"),
        Column("gap [points]", lambda row: f"{100 * row['criterion_gap']:+.1f}"),
        number("grasp [s]", "mean_time_to_grasp_s"),
        number("RMSE [mm]", "median_track_rmse_mm"),
        number("yaw [deg]", "median_track_yaw_rmse_deg"),
        number("grip [mm]", "median_close_error_mm"),
    )
    return Table(
        [names | _measures(members) for names, members in named_groups(results, keys)], columns
    )


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
        "mean_time_to_grasp_s": of_known(
            np.mean, (row.time_to_grasp_s for row in members if row.success)
        ),
        "median_track_rmse_mm": of_known(np.median, (row.track_rmse_m for row in members), 1e3),
        "median_track_yaw_rmse_deg": of_known(
            np.median, (row.track_yaw_rmse_rad for row in members), math.degrees(1.0)
        ),
        "median_close_error_mm": of_known(np.median, (row.close_error_m for row in members), 1e3),
    }


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
    """Returns how soon the object was tracked and grasped, the filter's ESS, and what was lost.

    Medians over the trials that came to the event, times from the object's full view; `lost` is
    how often a track turned to lost in all trials of the cell, `in trials` in how many of them.
    """
    keys = cell_keys(results)
    rows: list[TableRow] = []
    for names, members in named_groups(results, keys):
        row: TableRow = names | {"n": len(members)}
        for name, *_ in _TRACKING:
            values = [getattr(member, name) for member in members]
            row[name] = of_known(np.median, values)
            row[f"{name}_n"] = sum(value is not None for value in values)
        row["lost_count"] = sum(member.lost_count for member in members)
        row["loser_count"] = sum(member.lost_count > 0 for member in members)
        rows.append(row)
    lost = (("lost_count", "lost", 0), ("loser_count", "in trials", 0))
    return Table(rows, [*key_columns(keys), *words("n"), *numbers((*_TRACKING, *lost))])


_COSTS = (
    ("render_ms_per_image", "render [ms/image]", 1),
    ("track_ms_per_image", "track [ms/image]", 1),
    ("servo_ms_per_step", "servo [ms/step]", 2),
    ("physics_ms_per_step", "physics [ms/step]", 2),
    ("wall_s", "trial [s]", 1),
)
"""Column of timings.csv whose median is shown, its heading and its digits."""


def cost_table(results: Sequence[TrialResult], timings: Sequence[TrialTimings]) -> Table:
    """Returns what each stage cost on the machine of the sweep, for cells with a measured trial.

    Medians over the trials that did not crash; the real-time factor is that of all together.
    """
    cost_of = {row.trial_id: row for row in timings}
    keys = cell_keys(results)
    rows: list[TableRow] = []
    for names, members in named_groups(results, keys):
        known = [m for m in members if m.outcome != "error" and m.trial_id in cost_of]
        costs = [cost_of[member.trial_id] for member in known]
        if not costs:
            continue
        row: TableRow = names | {"n": len(costs)}
        for name, *_ in _COSTS:
            row[name] = of_known(np.median, (getattr(cost, name) for cost in costs))
        row["real_time_factor"] = sum(c.simulated_s for c in costs) / sum(c.wall_s for c in costs)
        rows.append(row)
    shown = (*_COSTS, ("real_time_factor", "x real time", 2))
    return Table(rows, [*key_columns(keys), *words("n"), *numbers(shown)])


def outcome_table(results: Sequence[TrialResult]) -> Table:
    """Returns how the trials of each cell ended: one column for each outcome that occurred."""
    keys = cell_keys(results)
    present = {row.outcome for row in results}
    outcomes: list[str] = [outcome for outcome in get_args(Outcome) if outcome in present]
    rows: list[TableRow] = []
    for names, members in named_groups(results, keys):
        counts = Counter[str](row.outcome for row in members)
        rows.append(names | {"n": len(members)} | {name: counts[name] for name in outcomes})
    return Table(rows, [*key_columns(keys), *words("n", *outcomes)])


def blame_table(results: Sequence[TrialResult]) -> Table:
    """Returns failures by whose they are; no rows without failures or without the oracle's trials.

    What the oracle grasps in the same world was there to be grasped, so the failure is one of
    tracking; what it does not is out of the arm's reach or time. The oracle sees no images, so
    its trials count for every camera, condition, predictor and delay.
    """
    graspable = {_belt_world(r): r.success for r in results if r.tracker == ORACLE}
    keys = cell_keys(results)
    rows: list[TableRow] = []
    for names, members in named_groups(results, keys):
        failures = [graspable.get(_belt_world(r)) for r in members if not r.success]
        if names["tracker"] == ORACLE or not failures or not graspable:
            continue
        counts = Counter(failures)
        shares = {"tracking": counts[True], "arm": counts[False], "unknown": counts[None]}
        rows.append(names | {"n": len(members), "failures": len(failures)} | shares)
    shown = words("n", "failures", "tracking", "arm", "unknown")
    return Table(rows, [*key_columns(keys), *shown])


def _belt_world(row: TrialResult) -> tuple[Any, ...]:
    """Returns what the oracle meets: arm, gripper, object, belt and seed."""
    return (
        row.embodiment,
        row.object,
        row.motion,
        row.speed_mps,
        row.gripper_delay_s,
        row.seed,
    )
