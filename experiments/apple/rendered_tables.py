"""The tables of the rendered experiments: methods by class and aspect, views, masks, poses."""

from collections.abc import Mapping, Sequence

import numpy as np

from experiments.apple.approach import ERROR_FIELDS, ApproachRow
from experiments.apple.methods import METHODS
from experiments.apple.photographs import ORACLE, SEGMENTED
from experiments.apple.replay import ReplayRow, published_errors_deg
from experiments.apple.viewpoints import VIEWS
from experiments.apple.worlds import CLASSES
from experiments.report.grouping import group_by
from experiments.report.statistics import bootstrap, median, median_difference, of_known
from experiments.report.table import Column, Table, TableRow, interval, number, rate, words
from experiments.seeding import Stream, generator

BEST = "silhouettes"
"""The method that the other tables are about."""
ALL = "all"
MEDIAN = ("median_deg", "median_low_deg", "median_high_deg")
"""Keys of a median and the bounds of its 95 % interval."""


def approach_tables(rows: Sequence[ApproachRow]) -> dict[str, Table]:
    """Returns every table under the name of its file."""
    return {
        "methods": method_table(rows),
        "views": views_table(rows),
        "masks": mask_table(rows),
        "segmentation": segmentation_table(rows),
        "images": image_table(rows),
    }


def method_table(rows: Sequence[ApproachRow]) -> Table:
    """Returns the median axis error of every method, by class and aspect, on the planned arc."""
    found: list[TableRow] = []
    chosen = [row for row in rows if row.mask == SEGMENTED and row.views == "arc"]
    for names, members in _settings(chosen):
        for method in METHODS:
            own = [row for row in members if row.method == method]
            if not own:
                continue
            errors = [row.error_deg for row in own]
            found.append(
                names
                | {"n": len(own), "method": method}
                | median_and_interval(errors)
                | {
                    "mean_deg": float(np.mean(errors)),
                    "p90_deg": float(np.percentile(errors, 90)),
                    "sign_right": float(np.mean([row.is_sign_right for row in own])),
                    "visible_share": float(np.median([row.visible_share for row in own])),
                }
            )
    return Table.of(
        found,
        *words("class", "aspect", "n", "method"),
        interval("axis error [deg], median [95 %]", *MEDIAN),
        number("mean", "mean_deg"),
        number("90 %", "p90_deg"),
        rate("stem end right %", "sign_right"),
    )


def views_table(rows: Sequence[ApproachRow]) -> Table:
    """Returns the planned approach beside the choice of the next best view, in the same worlds."""
    found: list[TableRow] = []
    of_best = [row for row in rows if row.method == BEST and row.mask == SEGMENTED]
    for names, members in _settings(of_best):
        ways = {
            views: {(row.aspect, row.seed): row for row in members if row.views == views}
            for views in VIEWS
        }
        both = sorted(set(ways["arc"]) & set(ways["next-best"]))
        if not both:
            continue
        row = names | {"n": len(both)}
        errors: dict[str, list[float]] = {}
        for views, key in (("arc", "arc"), ("next-best", "next_best")):
            own = [ways[views][world] for world in both]
            errors[views] = [r.error_deg for r in own]
            row |= _median_and_p90(key, errors[views])
            row[f"{key}_calyx"] = float(np.mean([r.calyx_count for r in own]))
        rng = generator(0, Stream.BOOTSTRAP)
        gain = bootstrap(median_difference, rng, errors["next-best"], errors["arc"])
        row |= dict(zip(("gain_deg", "gain_low_deg", "gain_high_deg"), gain, strict=True))
        found.append(row)
    return Table.of(
        found,
        *words("class", "aspect", "n"),
        number("arc: median [deg]", "arc_deg"),
        number("90 %", "arc_p90_deg"),
        number("images with calyx", "arc_calyx", 1),
        number("next best: median [deg]", "next_best_deg"),
        number("90 %", "next_best_p90_deg"),
        number("images with calyx", "next_best_calyx", 1),
        interval("difference [95 %]", "gain_deg", "gain_low_deg", "gain_high_deg", sign="+"),
    )


def mask_table(rows: Sequence[ApproachRow]) -> Table:
    """Returns errors with masks by segmentation and by the simulator: what segmentation costs."""
    found: list[TableRow] = []
    of_best = [row for row in rows if row.method == BEST and row.views == "arc"]
    for names, members in _settings(of_best):
        row = names | {"n": len(members) // 2}
        for mask in (SEGMENTED, ORACLE):
            row |= _median_and_p90(mask, [r.error_deg for r in members if r.mask == mask])
        found.append(row)
    return Table.of(
        found,
        *words("class", "aspect", "n"),
        number("by colour: median [deg]", f"{SEGMENTED}_deg"),
        number("90 %", f"{SEGMENTED}_p90_deg"),
        number("oracle masks: median [deg]", f"{ORACLE}_deg"),
        number("90 %", f"{ORACLE}_p90_deg"),
    )


def segmentation_table(rows: Sequence[ApproachRow]) -> Table:
    """Returns how much of the fruit could be seen, and how often it and its calyx were found."""
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
    return Table.of(
        found,
        *words("class", "views", "images"),
        rate("fruit in sight %, median", "visible_median"),
        rate("10 %", "visible_p10"),
        rate("fruit found %", "found"),
        rate("calyx found %", "calyx"),
        rate("taken by the arm %", "by_arm"),
    )


def image_table(rows: Sequence[ApproachRow]) -> Table:
    """Returns the median error after each image, by class and method: how fast each learns."""
    found: list[TableRow] = []
    of_masks = [row for row in rows if row.mask == SEGMENTED]
    keys = ("fruit_class", "views", "method")
    for (fruit_class, views, method), members in group_by(of_masks, keys).items():
        row: TableRow = {"class": fruit_class, "views": views, "method": method, "n": len(members)}
        for index, name in enumerate(ERROR_FIELDS, start=1):
            row[f"image_{index}_deg"] = float(np.median([getattr(r, name) for r in members]))
        found.append(row)
    images = range(1, len(ERROR_FIELDS) + 1)
    return Table.of(
        found,
        *words("class", "views", "method", "n"),
        *(number(f"{i}", f"image_{i}_deg") for i in images),
    )


def median_and_interval(errors_deg: Sequence[float]) -> TableRow:
    """Returns the cells of `MEDIAN`."""
    found = bootstrap(median, generator(0, Stream.BOOTSTRAP), errors_deg)
    return dict(zip(MEDIAN, found, strict=True))


def _settings(rows: Sequence[ApproachRow]) -> list[tuple[TableRow, list[ApproachRow]]]:
    """Groups rows by class and aspect and, where a class has several aspects, all together."""
    settings: list[tuple[TableRow, list[ApproachRow]]] = []
    for fruit_class in CLASSES:
        of_class = [row for row in rows if row.fruit_class == fruit_class]
        groups = {f"{a:g}": own for (a,), own in sorted(group_by(of_class, ["aspect"]).items())}
        if len(groups) > 1:
            groups[ALL] = of_class
        settings += [({"class": fruit_class, "aspect": a}, own) for a, own in groups.items()]
    return settings


def _median_and_p90(name: str, errors_deg: Sequence[float]) -> TableRow:
    return {
        f"{name}_deg": float(np.median(errors_deg)),
        f"{name}_p90_deg": float(np.percentile(errors_deg, 90)),
    }


def replay_tables(rows: Sequence[ReplayRow]) -> dict[str, Table]:
    """Returns every table under the name of its file."""
    return {"methods": replay_method_table(rows), "poses": pose_table(rows)}


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


def replay_method_table(rows: Sequence[ReplayRow]) -> Table:
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
