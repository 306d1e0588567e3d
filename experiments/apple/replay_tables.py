"""What the replays of the published poses say, beside what was published."""

from collections.abc import Mapping, Sequence

import numpy as np

from experiments.apple.approach_tables import MEDIAN, median_and_interval
from experiments.apple.methods import METHODS
from experiments.apple.observer import ORACLE, SEGMENTED
from experiments.apple.replay import ReplayRow, published_errors_deg
from experiments.report.grouping import group_by
from experiments.report.statistics import of_known
from experiments.report.table import Column, Table, TableRow, interval, number, words


def replay_tables(rows: Sequence[ReplayRow]) -> dict[str, Table]:
    """Returns every table under the name of its file."""
    return {"methods": method_table(rows), "poses": pose_table(rows)}


def final_errors_deg(rows: Sequence[ReplayRow]) -> list[float]:
    """Returns an error for each fruit: after the last image or, of single images, the mean."""
    errors: list[float] = []
    for members in group_by(rows, ("table", "aspect", "seed", "mask", "method")).values():
        is_fused = METHODS[members[0].method].is_fused
        last = max(members, key=lambda row: row.image)
        errors.append(
            last.error_deg if is_fused else float(np.mean([row.error_deg for row in members]))
        )
    return errors


def method_table(rows: Sequence[ReplayRow]) -> Table:
    """Returns the median axis error of every method at the end of each table, and as published."""
    found: list[TableRow] = []
    aspects = sorted({row.aspect for row in rows})
    of_aspect = {f"aspect_{aspect:g}_deg": aspect for aspect in aspects}
    unknown: TableRow = dict.fromkeys((*MEDIAN, "p90_deg", "oracle_deg", *of_aspect))
    for table in sorted({row.table for row in rows}):
        of_table = [row for row in rows if row.table == table]
        names = ("published, one image (mean)", "published, filter (end)")
        for name, error_deg in zip(names, published_errors_deg(table), strict=True):
            row: TableRow = {"table": table, "method": name, "n": None}
            found.append(row | unknown | {"median_deg": error_deg})
        for method in METHODS:
            own = [row for row in of_table if row.method == method]
            if own:
                found.append(_method_row(table, method, own, of_aspect))
    return Table.of(
        found,
        *words("table", "method", "n"),
        interval("axis error [deg], median [95 %]", *MEDIAN),
        number("90 %", "p90_deg"),
        *(number(f"aspect {aspect:g}", key) for key, aspect in of_aspect.items()),
        number("oracle masks", "oracle_deg"),
    )


def pose_table(rows: Sequence[ReplayRow]) -> Table:
    """Returns the published poses: distance to the fruit, who carried the camera, what it saw."""
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
    return Table.of(
        found,
        *words("table", "image", "n"),
        number("distance [m]", "range_m"),
        Column("camera", lambda row: "arm" if row["by_arm"] else "free"),
        number("fruit found %", "found", 0, 100.0),
        number("calyx found %", "calyx", 0, 100.0),
    )


def _method_row(
    table: int, method: str, rows: Sequence[ReplayRow], aspects: Mapping[str, float]
) -> TableRow:
    own = [row for row in rows if row.mask == SEGMENTED]
    errors = final_errors_deg(own)
    row: TableRow = {"table": table, "method": method, "n": len(errors)}
    row |= median_and_interval(errors)
    row["p90_deg"] = float(np.percentile(errors, 90))
    of_oracle = final_errors_deg([r for r in rows if r.mask == ORACLE])
    row["oracle_deg"] = float(np.median(of_oracle))
    for key, aspect in aspects.items():
        of_aspect = final_errors_deg([r for r in own if r.aspect == aspect])
        row[key] = of_known(np.median, of_aspect)
    return row
