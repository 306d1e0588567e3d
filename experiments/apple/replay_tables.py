"""What the replays of the published poses say, beside what was published."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from experiments.apple.methods import METHODS
from experiments.apple.observer import ORACLE, SEGMENTED
from experiments.apple.replay import ReplayRow, published_errors_deg
from experiments.report.grouping import group_by
from experiments.report.statistics import bootstrap_median
from experiments.report.table import Column, Table, TableRow, show_number
from experiments.seeding import Stream, generator

ALL = "all"


def replay_tables(rows: Sequence[ReplayRow]) -> dict[str, Table]:
    """Every table under the name of its file."""
    return {"methods": method_table(rows), "poses": pose_table(rows)}


def final_errors_deg(rows: Sequence[ReplayRow]) -> list[float]:
    """One error for each fruit: after the last image or, of single images, the mean of all."""
    errors: list[float] = []
    for members in group_by(rows, ("table", "aspect", "seed", "mask", "method")).values():
        is_fused = METHODS[members[0].method].is_fused
        last = max(members, key=lambda row: row.image)
        errors.append(
            last.error_deg if is_fused else float(np.mean([row.error_deg for row in members]))
        )
    return errors


def method_table(rows: Sequence[ReplayRow]) -> Table:
    """Median axis error of every method at the end of each table, and the published errors."""
    found: list[TableRow] = []
    for table in sorted({row.table for row in rows}):
        of_table = [row for row in rows if row.table == table]
        single, end = published_errors_deg(table)
        found.append(_published(table, "published, one image (mean)", single))
        found.append(_published(table, "published, filter (end)", end))
        for method in METHODS:
            own = [row for row in of_table if row.method == method]
            if own:
                found.append(_method_row(table, method, own))
    return Table(
        tuple(found),
        (
            Column("table", lambda row: str(row["table"])),
            Column("method", lambda row: row["method"]),
            Column("n", lambda row: "-" if row["n"] is None else str(row["n"])),
            Column("axis error [deg], median [95 %]", _interval),
            Column("90 %", lambda row: show_number(row["p90_deg"])),
            *(
                Column(
                    f"aspect {aspect:g}", lambda row, key=f"aspect_{aspect:g}_deg": _one(row, key)
                )
                for aspect in sorted({row.aspect for row in rows})
            ),
            Column("oracle masks", lambda row: show_number(row["oracle_deg"])),
        ),
    )


def pose_table(rows: Sequence[ReplayRow]) -> Table:
    """The published poses: how far from the fruit, who carried the camera, what was seen."""
    found: list[TableRow] = []
    one_method = next(iter(METHODS))
    chosen = [row for row in rows if row.mask == SEGMENTED and row.method == one_method]
    for (table, image), members in sorted(group_by(chosen, ("table", "image")).items()):
        found.append(
            {
                "table": table,
                "image": image,
                "n": len(members),
                "range_m": float(np.median([row.range_m for row in members])),
                "by_arm": all(row.by_arm for row in members),
                "found": float(np.mean([row.status == "found" for row in members])),
                "calyx": float(np.mean([row.is_calyx_found for row in members])),
            }
        )
    return Table(
        tuple(found),
        (
            *(Column(n, lambda row, n=n: str(row[n])) for n in ("table", "image", "n")),
            Column("distance [m]", lambda row: show_number(row["range_m"])),
            Column("camera", lambda row: "arm" if row["by_arm"] else "free"),
            Column("fruit found %", lambda row: show_number(100 * row["found"], 0)),
            Column("calyx found %", lambda row: show_number(100 * row["calyx"], 0)),
        ),
    )


def _method_row(table: int, method: str, rows: Sequence[ReplayRow]) -> TableRow:
    own = [row for row in rows if row.mask == SEGMENTED]
    errors = final_errors_deg(own)
    middle, low, high = bootstrap_median(errors, generator(0, Stream.BOOTSTRAP))
    row: TableRow = {
        "table": table,
        "method": method,
        "n": len(errors),
        "median_deg": middle,
        "median_low_deg": low,
        "median_high_deg": high,
        "p90_deg": float(np.percentile(errors, 90)),
        "oracle_deg": float(np.median(final_errors_deg([r for r in rows if r.mask == ORACLE]))),
    }
    for aspect in sorted({r.aspect for r in own}):
        of_aspect = final_errors_deg([r for r in own if r.aspect == aspect])
        row[f"aspect_{aspect:g}_deg"] = float(np.median(of_aspect))
    return row


def _published(table: int, name: str, error_deg: float) -> TableRow:
    return {
        "table": table,
        "method": name,
        "n": None,
        "median_deg": error_deg,
        "median_low_deg": None,
        "median_high_deg": None,
        "p90_deg": None,
        "oracle_deg": None,
    }


def _interval(row: TableRow) -> str:
    if row["median_low_deg"] is None:
        return f"{row['median_deg']:.2f}"
    return f"{row['median_deg']:.2f} [{row['median_low_deg']:.2f}, {row['median_high_deg']:.2f}]"


def _one(row: TableRow, key: str) -> str:
    return show_number(row.get(key))
