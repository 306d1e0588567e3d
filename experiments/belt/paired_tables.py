"""What differs on the same worlds: the reference tracker from others, a condition from normal."""

from __future__ import annotations

from collections.abc import Sequence

from experiments.belt.comparison import SIGNIFICANCE, Comparison, pooled
from experiments.belt.config import TrialResult
from experiments.belt.tables import key_columns
from experiments.report.grouping import cell_keys, group_by, world_of
from experiments.report.statistics import holm
from experiments.report.table import Column, Table, TableRow, show_rate
from sim.imaging.degradations import NORMAL

REFERENCE_TRACKER = "igpf"
"""The tracker that the others are compared with, world by world."""


def paired_tables(results: Sequence[TrialResult]) -> dict[str, Table]:
    """`paired`, a row for each cell and rival, and `verdicts`, a row for each rival.

    Empty where no cell has worlds that the reference tracker and another one have met. Holm's p
    [Holm1979] takes the cells of a rival as one family: a cell in twenty would come out at
    p < 0.05 by accident.
    """
    keys = cell_keys(results)
    cells = group_by(results, keys)
    pairs: dict[str, dict[tuple[object, ...], Comparison]] = {}
    for cell, members in cells.items():
        reference = cells.get((REFERENCE_TRACKER, *cell[1:]))
        if cell[0] != REFERENCE_TRACKER and reference is not None:
            compared = _compare(reference, members)
            if compared.n:
                pairs.setdefault(cell[0], {})[cell] = compared
    if not pairs:
        return {}
    rows: list[TableRow] = []
    verdicts: list[TableRow] = []
    for rival, comparisons in pairs.items():
        adjusted = holm([c.p for c in comparisons.values()])
        for (cell, compared), p in zip(comparisons.items(), adjusted, strict=True):
            rows.append(dict(zip(keys, cell, strict=True)) | _measures(compared) | {"holm_p": p})
        verdicts.append(_verdict(rival, list(comparisons.values()), adjusted))
    return {"paired": _paired(keys, rows), "verdicts": _verdicts(verdicts)}


def condition_table(results: Sequence[TrialResult]) -> Table | None:
    """What each condition costs a tracker against the normal one in the same worlds, all speeds.

    The seed lays the object alike under every condition. None without trials under both.
    """
    keys = [key for key in cell_keys(results) if key != "speed_mps"]
    place = keys.index("condition")
    cells = group_by(results, keys)
    rows: list[TableRow] = []
    for cell, members in cells.items():
        normal = cells.get((*cell[:place], NORMAL, *cell[place + 1 :]))
        if cell[place] != NORMAL and normal is not None:
            compared = Comparison.of(
                *({(r.speed_mps, r.seed): r.success for r in group} for group in (members, normal))
            )
            if compared.n:
                rows.append(dict(zip(keys, cell, strict=True)) | _measures(compared))
    columns = (
        *key_columns(keys),
        *_difference_columns("condition", NORMAL),
        Column("condition is", lambda row: row["verdict"]),
    )
    return Table(tuple(rows), columns) if rows else None


def _compare(reference: Sequence[TrialResult], rival: Sequence[TrialResult]) -> Comparison:
    """Paired: only worlds that both have met."""
    return Comparison.of(*({world_of(r): r.success for r in rows} for rows in (reference, rival)))


def _measures(pairs: Comparison) -> TableRow:
    difference, low, high = pairs.difference
    return {
        "n": pairs.n,
        "first_rate": (pairs.both + pairs.first_only) / pairs.n,
        "second_rate": (pairs.both + pairs.second_only) / pairs.n,
        "first_only": pairs.first_only,
        "second_only": pairs.second_only,
        "difference": difference,
        "difference_low": low,
        "difference_high": high,
        "mcnemar_p": pairs.p,
        "verdict": pairs.verdict,
    }


def _verdict(rival: str, comparisons: Sequence[Comparison], adjusted: Sequence[float]) -> TableRow:
    """How many cells decide for whom, and all worlds of all cells together."""
    verdicts = [compared.verdict for compared in comparisons]
    sure = [v for v, p in zip(verdicts, adjusted, strict=True) if p < SIGNIFICANCE]
    row: TableRow = {"tracker": rival, "cells": len(comparisons)}
    row |= {name: verdicts.count(name) for name in ("better", "worse", "undecided")}
    row |= {f"holm_{name}": sure.count(name) for name in ("better", "worse")}
    return row | _measures(pooled(comparisons))


def _paired(keys: Sequence[str], rows: Sequence[TableRow]) -> Table:
    columns = (
        *key_columns(keys),
        *_difference_columns(REFERENCE_TRACKER, "tracker"),
        Column("Holm p", lambda row: show_p(row["holm_p"])),
        Column(f"{REFERENCE_TRACKER} is", lambda row: row["verdict"]),
    )
    return Table(tuple(rows), columns)


def _verdicts(rows: Sequence[TableRow]) -> Table:
    counted = ("tracker", "cells", "better", "worse", "undecided")
    heads = {"tracker": "against", "better": f"{REFERENCE_TRACKER} better"}
    columns = (
        *(Column(heads.get(key, key), lambda row, key=key: str(row[key])) for key in counted),
        Column("better (Holm)", lambda row: str(row["holm_better"])),
        Column("worse (Holm)", lambda row: str(row["holm_worse"])),
        *_difference_columns(REFERENCE_TRACKER, "tracker"),
    )
    return Table(tuple(rows), columns)


def _difference_columns(first: str, second: str) -> tuple[Column, ...]:
    return (
        Column("n", lambda row: str(row["n"])),
        Column(f"{first} %", lambda row: show_rate(row["first_rate"])),
        Column(f"{second} %", lambda row: show_rate(row["second_rate"])),
        Column(f"only {first}", lambda row: str(row["first_only"])),
        Column(f"only {second}", lambda row: str(row["second_only"])),
        Column(
            "difference, points [95 %]",
            lambda row: (
                f"{100 * row['difference']:+.1f} "
                f"[{100 * row['difference_low']:+.1f}, {100 * row['difference_high']:+.1f}]"
            ),
        ),
        Column("McNemar p", lambda row: show_p(row["mcnemar_p"])),
    )


def show_p(p: float) -> str:
    """A p-value in three digits; where that would be hair-splitting, its bound."""
    return "< 0.001" if p < 0.001 else f"{p:.3f}"
