"""What differs on the same worlds: the reference tracker from others, a condition from normal."""

from collections.abc import Iterator, Sequence

from experiments.belt.analysis.cells import cell_keys, condition_keys, key_columns, world_of
from experiments.belt.analysis.comparison import Comparison, pooled
from experiments.belt.config import TrialResult
from experiments.report.grouping import group_by
from experiments.report.statistics import SIGNIFICANCE, holm
from experiments.report.table import Column, Table, TableRow, interval, p_value, rate, word, words
from sim.imaging.degradations import NORMAL

REFERENCE_TRACKER = "igpf"
"""The tracker that the others are compared with, world by world."""


def rivals(
    results: Sequence[TrialResult], keys: Sequence[str], key: str = "tracker"
) -> Iterator[tuple[TableRow, list[TrialResult], list[TrialResult]]]:
    """Yields the names of each cell, the trials of its counterpart, and its own.

    Args:
        results: All trials.
        keys: Columns that name a cell.
        key: The one that differs: the counterpart of a tracker's cell is that of the reference
            tracker, the counterpart of a condition's the normal one. Others are left out.
    """
    place, value = keys.index(key), {"tracker": REFERENCE_TRACKER, "condition": NORMAL}[key]
    cells = group_by(results, keys)
    for cell, members in cells.items():
        counterpart = cells.get((*cell[:place], value, *cell[place + 1 :]))
        if cell[place] != value and counterpart is not None:
            yield dict(zip(keys, cell, strict=True)), counterpart, members


def paired_tables(results: Sequence[TrialResult]) -> dict[str, Table]:
    """Returns `paired`, a row for each cell and rival, and `verdicts`, a row for each rival.

    Without rows where no cell has worlds that the reference tracker and another one have met.
    Holm's p [Holm1979] takes the cells of a rival as one family: a cell in twenty would come out at
    p < 0.05 by accident.
    """
    keys = cell_keys(results)
    pairs: dict[str, list[tuple[TableRow, Comparison]]] = {}
    for names, reference, members in rivals(results, keys):
        compared = _compare(reference, members)
        if compared.n:
            pairs.setdefault(names["tracker"], []).append((names, compared))
    rows: list[TableRow] = []
    verdicts: list[TableRow] = []
    for rival, cells in pairs.items():
        comparisons = [compared for _, compared in cells]
        adjusted = holm([compared.p for compared in comparisons])
        for (names, compared), p in zip(cells, adjusted, strict=True):
            rows.append(names | _measures(compared) | {"holm_p": p})
        verdicts.append(_verdict(rival, comparisons, adjusted))
    return {"paired": _paired(keys, rows), "verdicts": _verdicts(verdicts)}


def condition_table(results: Sequence[TrialResult]) -> Table:
    """Returns what each condition costs a tracker against the normal one, all speeds together.

    The seed lays the object alike under every condition. No rows without trials under both.
    """
    keys = condition_keys(results)
    rows: list[TableRow] = []
    for names, normal, members in rivals(results, keys, "condition"):
        compared = Comparison.of(
            *({(r.speed_mps, r.seed): r.success for r in group} for group in (members, normal))
        )
        if compared.n:
            rows.append(names | _measures(compared))
    difference = _difference_columns("condition", NORMAL)
    return Table(rows, [*key_columns(keys), *difference, word("condition is", "verdict")])


def _compare(reference: Sequence[TrialResult], rival: Sequence[TrialResult]) -> Comparison:
    """Pairs the worlds that both have met."""
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
    """Counts the cells by verdict, and pools the worlds of all cells."""
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
        p_value("Holm p", "holm_p"),
        word(f"{REFERENCE_TRACKER} is", "verdict"),
    )
    return Table(rows, columns)


def _verdicts(rows: Sequence[TableRow]) -> Table:
    columns = (
        word("against", "tracker"),
        word("cells", "cells"),
        word(f"{REFERENCE_TRACKER} better", "better"),
        *words("worse", "undecided"),
        word("better (Holm)", "holm_better"),
        word("worse (Holm)", "holm_worse"),
        *_difference_columns(REFERENCE_TRACKER, "tracker"),
    )
    return Table(rows, columns)


def _difference_columns(first: str, second: str) -> tuple[Column, ...]:
    return (
        *words("n"),
        rate(f"{first} %", "first_rate"),
        rate(f"{second} %", "second_rate"),
        word(f"only {first}", "first_only"),
        word(f"only {second}", "second_only"),
        interval(
            "difference, points [95 %]",
            "difference",
            "difference_low",
            "difference_high",
            digits=1,
            factor=100.0,
            sign="+",
        ),
        p_value("McNemar p", "mcnemar_p"),
    )
