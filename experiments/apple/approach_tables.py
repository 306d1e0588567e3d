"""What the approaches say: every method by class and aspect, ways to look, and the masks."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from experiments.apple.approach import ERROR_FIELDS, ApproachRow
from experiments.apple.methods import METHODS
from experiments.apple.observer import ORACLE, SEGMENTED
from experiments.apple.viewpoints import VIEWS
from experiments.apple.worlds import CLASSES
from experiments.report.grouping import group_by
from experiments.report.statistics import bootstrap_median, bootstrap_median_difference
from experiments.report.table import Column, Table, TableRow, show_number, show_rate
from experiments.seeding import Stream, generator

BEST = "silhouettes"
"""The method that the other tables are about."""
ALL = "all"


def approach_tables(rows: Sequence[ApproachRow]) -> dict[str, Table]:
    """Every table under the name of its file; those without rows are left out."""
    tables = {
        "methods": method_table(rows),
        "views": views_table(rows),
        "masks": mask_table(rows),
        "segmentation": segmentation_table(rows),
        "images": image_table(rows),
    }
    return {name: table for name, table in tables.items() if table.rows}


def method_table(rows: Sequence[ApproachRow]) -> Table:
    """Median axis error of every method, by class and aspect, on the planned approach."""
    found: list[TableRow] = []
    for (fruit_class, aspect), members in _settings(_chosen(rows)):
        for method, own in _by_method(members).items():
            errors = [row.error_deg for row in own]
            middle, low, high = _median(errors)
            found.append(
                {
                    "class": fruit_class,
                    "aspect": aspect,
                    "n": len(own),
                    "method": method,
                    "median_deg": middle,
                    "median_low_deg": low,
                    "median_high_deg": high,
                    "mean_deg": float(np.mean(errors)),
                    "p90_deg": float(np.percentile(errors, 90)),
                    "sign_right": float(np.mean([row.is_sign_right for row in own])),
                    "visible_share": float(np.median([row.visible_share for row in own])),
                }
            )
    return Table(
        tuple(found),
        (
            *_words("class", "aspect", "n", "method"),
            Column("axis error [deg], median [95 %]", _interval),
            _number("mean", "mean_deg"),
            _number("90 %", "p90_deg"),
            Column("stem end right %", lambda row: show_rate(row["sign_right"])),
        ),
    )


def views_table(rows: Sequence[ApproachRow]) -> Table:
    """The planned approach beside the choice of the next best view, in the same worlds."""
    found: list[TableRow] = []
    of_best = [row for row in rows if row.method == BEST and row.mask == SEGMENTED]
    for (fruit_class, aspect), members in _settings(of_best):
        ways = {
            views: {(row.aspect, row.seed): row for row in members if row.views == views}
            for views in VIEWS
        }
        both = sorted(set(ways["arc"]) & set(ways["next-best"]))
        if not both:
            continue
        arc, best = ([ways[v][key].error_deg for key in both] for v in ("arc", "next-best"))
        gain, low, high = bootstrap_median_difference(best, arc, generator(0, Stream.BOOTSTRAP))
        calyx = {v: np.mean([ways[v][key].calyx_count for key in both]) for v in VIEWS}
        found.append(
            {
                "class": fruit_class,
                "aspect": aspect,
                "n": len(both),
                "arc_deg": float(np.median(arc)),
                "arc_p90_deg": float(np.percentile(arc, 90)),
                "arc_calyx": float(calyx["arc"]),
                "next_best_deg": float(np.median(best)),
                "next_best_p90_deg": float(np.percentile(best, 90)),
                "next_best_calyx": float(calyx["next-best"]),
                "gain_deg": gain,
                "gain_low_deg": low,
                "gain_high_deg": high,
            }
        )
    return Table(
        tuple(found),
        (
            *_words("class", "aspect", "n"),
            _number("arc: median [deg]", "arc_deg"),
            _number("90 %", "arc_p90_deg"),
            _number("images with calyx", "arc_calyx", 1),
            _number("next best: median [deg]", "next_best_deg"),
            _number("90 %", "next_best_p90_deg"),
            _number("images with calyx", "next_best_calyx", 1),
            Column(
                "difference [95 %]",
                lambda row: (
                    f"{row['gain_deg']:+.2f} "
                    f"[{row['gain_low_deg']:+.2f}, {row['gain_high_deg']:+.2f}]"
                ),
            ),
        ),
    )


def mask_table(rows: Sequence[ApproachRow]) -> Table:
    """Errors with the fruit told by segmentation, and by the simulator: what segmentation costs."""
    found: list[TableRow] = []
    of_best = [row for row in rows if row.method == BEST and row.views == "arc"]
    for (fruit_class, aspect), members in _settings(of_best):
        row: TableRow = {"class": fruit_class, "aspect": aspect, "n": len(members) // 2}
        for mask in (SEGMENTED, ORACLE):
            errors = [r.error_deg for r in members if r.mask == mask]
            row[f"{mask}_deg"] = float(np.median(errors))
            row[f"{mask}_p90_deg"] = float(np.percentile(errors, 90))
        found.append(row)
    return Table(
        tuple(found),
        (
            *_words("class", "aspect", "n"),
            _number("by colour: median [deg]", f"{SEGMENTED}_deg"),
            _number("90 %", f"{SEGMENTED}_p90_deg"),
            _number("oracle masks: median [deg]", f"{ORACLE}_deg"),
            _number("90 %", f"{ORACLE}_p90_deg"),
        ),
    )


def segmentation_table(rows: Sequence[ApproachRow]) -> Table:
    """How much of the fruit could be seen, and how often segmentation found it and its calyx."""
    found: list[TableRow] = []
    of_one = [row for row in rows if row.method == BEST and row.mask == SEGMENTED]
    for (fruit_class, views), members in group_by(of_one, ("fruit_class", "views")).items():
        images = sum(row.image_count for row in members)
        shares = [row.visible_share for row in members]
        found.append(
            {
                "class": fruit_class,
                "views": views,
                "images": images,
                "visible_median": float(np.median(shares)),
                "visible_p10": float(np.percentile(shares, 10)),
                "found": sum(row.found_count for row in members) / images,
                "calyx": sum(row.calyx_count for row in members) / images,
                "by_arm": sum(row.arm_count for row in members) / images,
            }
        )
    return Table(
        tuple(found),
        (
            *_words("class", "views", "images"),
            Column("fruit in sight %, median", lambda row: show_rate(row["visible_median"])),
            Column("10 %", lambda row: show_rate(row["visible_p10"])),
            Column("fruit found %", lambda row: show_rate(row["found"])),
            Column("calyx found %", lambda row: show_rate(row["calyx"])),
            Column("taken by the arm %", lambda row: show_rate(row["by_arm"])),
        ),
    )


def image_table(rows: Sequence[ApproachRow]) -> Table:
    """Median error after each image, by class and method: how fast each method learns."""
    found: list[TableRow] = []
    of_masks = [row for row in rows if row.mask == SEGMENTED]
    keys = ("fruit_class", "views", "method")
    for (fruit_class, views, method), members in group_by(of_masks, keys).items():
        row: TableRow = {"class": fruit_class, "views": views, "method": method, "n": len(members)}
        for index, name in enumerate(ERROR_FIELDS, start=1):
            row[f"image_{index}_deg"] = float(np.median([getattr(r, name) for r in members]))
        found.append(row)
    return Table(
        tuple(found),
        (
            *_words("class", "views", "method", "n"),
            *(_number(f"{i}", f"image_{i}_deg") for i in range(1, len(ERROR_FIELDS) + 1)),
        ),
    )


def _chosen(rows: Sequence[ApproachRow]) -> list[ApproachRow]:
    return [row for row in rows if row.mask == SEGMENTED and row.views == "arc"]


def _settings(
    rows: Sequence[ApproachRow],
) -> list[tuple[tuple[str, str], list[ApproachRow]]]:
    """Rows of each class, by aspect and, where there are several, of all aspects together."""
    settings: list[tuple[tuple[str, str], list[ApproachRow]]] = []
    for fruit_class in CLASSES:
        of_class = [row for row in rows if row.fruit_class == fruit_class]
        aspects = sorted({row.aspect for row in of_class})
        for aspect in aspects:
            own = [row for row in of_class if row.aspect == aspect]
            settings.append(((fruit_class, f"{aspect:g}"), own))
        if len(aspects) > 1:
            settings.append(((fruit_class, ALL), of_class))
    return settings


def _by_method(rows: Sequence[ApproachRow]) -> dict[str, list[ApproachRow]]:
    grouped = {name: [row for row in rows if row.method == name] for name in METHODS}
    return {name: own for name, own in grouped.items() if own}


def _median(values: Sequence[float]) -> tuple[float, float, float]:
    return bootstrap_median(values, generator(0, Stream.BOOTSTRAP))


def _interval(row: TableRow) -> str:
    return f"{row['median_deg']:.2f} [{row['median_low_deg']:.2f}, {row['median_high_deg']:.2f}]"


def _number(label: str, key: str, digits: int = 2) -> Column:
    show: Callable[[TableRow], str] = lambda row: show_number(row[key], digits)  # noqa: E731
    return Column(label, show)


def _words(*names: str) -> tuple[Column, ...]:
    return tuple(Column(name, lambda row, name=name: str(row[name])) for name in names)
