"""Tables rebuilt from the rows of trials.csv and nothing else."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias, get_args

import numpy as np

from experiments.comparison import Comparison, world_of
from experiments.config import Outcome, TrialResult
from experiments.records import csv_line
from experiments.statistics import wilson_interval

TableRow: TypeAlias = dict[str, Any]

REFERENCE_TRACKER = "igpf"
"""The tracker that the others are compared with, world by world."""

ORACLE = "oracle"
"""The control arm whose failures are nobody's tracking."""


@dataclass(frozen=True)
class Column:
    """One column of a table for people; the CSV holds the raw values instead."""

    label: str
    show: Callable[[TableRow], str]


@dataclass(frozen=True)
class Table:
    """Raw rows, and how people see them."""

    rows: tuple[TableRow, ...]
    columns: tuple[Column, ...]

    def to_csv(self) -> str:
        """Every raw value, one scalar a cell."""
        return csv_line(self.rows[0]) + "".join(csv_line(row.values()) for row in self.rows)

    def to_markdown(self) -> str:
        """The shown columns as a Markdown table."""
        labels, *body = self._shown()
        lines = [labels, ["---"] * len(labels), *body]
        return "".join("| " + " | ".join(cells) + " |\n" for cells in lines)

    def to_text(self) -> str:
        """The shown columns aligned for a terminal: words to the left, numbers to the right."""
        cells = self._shown()
        widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
        is_word = [isinstance(value, str) for value in list(self.rows[0].values())[: len(widths)]]
        lines = [
            "  ".join(
                cell.ljust(width) if word else cell.rjust(width)
                for cell, width, word in zip(row, widths, is_word, strict=True)
            ).rstrip()
            for row in cells
        ]
        lines.insert(1, "  ".join("-" * width for width in widths))
        return "\n".join(lines) + "\n"

    def write(self, folder: Path, name: str) -> list[Path]:
        """Writes NAME.csv and NAME.md."""
        folder.mkdir(parents=True, exist_ok=True)
        paths = [folder / f"{name}.csv", folder / f"{name}.md"]
        for path, text in zip(paths, (self.to_csv(), self.to_markdown()), strict=True):
            path.write_text(text, encoding="utf-8")
        return paths

    def _shown(self) -> list[list[str]]:
        head = [column.label for column in self.columns]
        return [head, *([column.show(row) for column in self.columns] for row in self.rows)]


def show_number(value: float | None, digits: int = 2) -> str:
    """The one way in which a table shows a number; a dash where there is none."""
    return "-" if value is None or math.isnan(value) else f"{value:.{digits}f}"


def show_rate(rate: float) -> str:
    """A rate in percent."""
    return show_number(100.0 * rate, 1)


def cell_keys(results: Sequence[TrialResult]) -> list[str]:
    """Columns that name a cell: the usual four, and others that vary in these results."""
    others = ("embodiment", "object", "motion", "predictor", "delay_s")
    varying = [key for key in others if len({getattr(row, key) for row in results}) > 1]
    return ["tracker", "camera", "condition", *varying, "speed_mps"]


def group_by_cell(
    results: Sequence[TrialResult], keys: Sequence[str]
) -> dict[tuple[Any, ...], list[TrialResult]]:
    """Results by the values of `keys`, in order of first appearance."""
    cells: dict[tuple[Any, ...], list[TrialResult]] = {}
    for row in results:
        cells.setdefault(tuple(getattr(row, key) for key in keys), []).append(row)
    return cells


def success_table(results: Sequence[TrialResult]) -> Table:
    """Success rates with Wilson 95 % intervals, and how fast and how exact the arm was.

    A trial that crashed counts as a failure. Time to grasp is the mean over successes; tracking
    and grip errors are medians over the trials that have them.
    """
    keys = cell_keys(results)
    rows = [
        dict(zip(keys, cell, strict=True)) | _measures(members)
        for cell, members in group_by_cell(results, keys).items()
    ]
    columns = (
        *_key_columns(keys),
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


def _key_columns(keys: Sequence[str]) -> list[Column]:
    return [Column(_LABELS.get(key, key), lambda row, key=key: show_key(row[key])) for key in keys]


_LABELS = {"speed_mps": "speed [m/s]", "delay_s": "delay [s]"}


def show_key(value: str | float) -> str:
    """A value that names a cell: a name as it is, a number in as few digits as tell it apart."""
    return value if isinstance(value, str) else f"{value:.2f}" if value >= 0.1 else f"{value:.3g}"


def outcome_table(results: Sequence[TrialResult]) -> Table:
    """How the trials of each cell ended: one column for each outcome that occurred."""
    keys = cell_keys(results)
    present = {row.outcome for row in results}
    outcomes: list[str] = [outcome for outcome in get_args(Outcome) if outcome in present]
    rows: list[TableRow] = []
    for cell, members in group_by_cell(results, keys).items():
        counts = Counter(row.outcome for row in members)
        row: TableRow = dict(zip(keys, cell, strict=True)) | {"n": len(members)}
        rows.append(row | {outcome: counts[outcome] for outcome in outcomes})
    counted = [Column(name, lambda row, name=name: str(row[name])) for name in ("n", *outcomes)]
    return Table(tuple(rows), (*_key_columns(keys), *counted))


def paired_table(results: Sequence[TrialResult]) -> Table | None:
    """Every tracker against the reference one on the same worlds; None without such pairs."""
    keys = cell_keys(results)
    cells = group_by_cell(results, keys)
    rows: list[TableRow] = []
    for cell, members in cells.items():
        reference = cells.get((REFERENCE_TRACKER, *cell[1:]))
        if cell[0] != REFERENCE_TRACKER and reference is not None:
            compared = _compare(members, reference)
            rows.append(dict(zip(keys, cell, strict=True)) | compared)
    columns = (
        *_key_columns(keys),
        Column("pairs", lambda row: str(row["n"])),
        Column(
            f"success minus {REFERENCE_TRACKER}, points [95 %]",
            lambda row: (
                f"{100 * row['difference']:+.1f} "
                f"[{100 * row['difference_low']:+.1f}, {100 * row['difference_high']:+.1f}]"
            ),
        ),
        Column("McNemar p", lambda row: f"{row['mcnemar_p']:.3g}"),
    )
    return Table(tuple(rows), columns) if rows else None


def _compare(members: Sequence[TrialResult], reference: Sequence[TrialResult]) -> TableRow:
    """Paired: only worlds that both have met."""
    success, expected = ({world_of(r): r.success for r in rows} for rows in (members, reference))
    pairs = Comparison.of(success, expected)
    difference, low, high = pairs.difference
    return {
        "n": pairs.n,
        "tracker_only": pairs.first_only,
        "reference_only": pairs.second_only,
        "difference": difference,
        "difference_low": low,
        "difference_high": high,
        "mcnemar_p": pairs.p,
    }


def blame_table(results: Sequence[TrialResult]) -> Table | None:
    """Failures by whose they are; None without failures or without the oracle's trials.

    What the oracle grasps in the same world was there to be grasped, so the failure is one of
    tracking; what it does not is out of the arm's reach or time. The oracle sees no images, so
    its trials count for every camera, condition, predictor and delay.
    """
    graspable = {_belt_world(r): r.success for r in results if r.tracker == ORACLE}
    keys = cell_keys(results)
    rows: list[TableRow] = []
    for cell, members in group_by_cell(results, keys).items():
        failures = [graspable.get(_belt_world(r)) for r in members if not r.success]
        if cell[0] == ORACLE or not failures or not graspable:
            continue
        counts = Counter(failures)
        row: TableRow = dict(zip(keys, cell, strict=True)) | {"n": len(members)}
        shares = {"tracking": counts[True], "arm": counts[False], "unknown": counts[None]}
        rows.append(row | {"failures": len(failures)} | shares)
    shown = ("n", "failures", "tracking", "arm", "unknown")
    columns = [Column(name, lambda row, name=name: str(row[name])) for name in shown]
    return Table(tuple(rows), (*_key_columns(keys), *columns)) if rows else None


def _belt_world(row: TrialResult) -> tuple[Any, ...]:
    """What the oracle meets: the arm, the object, the belt and the seed."""
    return row.embodiment, row.object, row.motion, row.speed_mps, row.seed
