"""Who sees the target more exactly on the same worlds, whatever became of the grasp."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import median

from experiments.belt.comparison import SIGNIFICANCE
from experiments.belt.config import TrialResult
from experiments.belt.paired_tables import REFERENCE_TRACKER, show_p
from experiments.belt.tables import key_columns
from experiments.report.grouping import cell_keys, group_by, world_of
from experiments.report.statistics import holm, mcnemar_exact
from experiments.report.table import Column, Table, TableRow


def accuracy_table(results: Sequence[TrialResult]) -> Table | None:
    """A row for each rival and condition, all speeds together; None without pairs.

    In each world that both have tracked the smaller error of the tracked position wins; the p is
    the exact sign test's [Dixon1946], and Holm's over the conditions of a rival [Holm1979]. The
    ratio is the geometric mean of the rival's error over the reference's.
    """
    keys = [key for key in cell_keys(results) if key != "speed_mps"]
    cells = group_by(results, keys)
    rows: dict[object, list[TableRow]] = {}
    for cell, members in cells.items():
        reference = cells.get((REFERENCE_TRACKER, *cell[1:]))
        if cell[0] != REFERENCE_TRACKER and reference is not None:
            pairs = _paired_errors(reference, members)
            if pairs:
                measures = dict(zip(keys, cell, strict=True)) | _measures(pairs)
                rows.setdefault(cell[0], []).append(measures)
    for family in rows.values():
        for row, p in zip(family, holm([row["sign_p"] for row in family]), strict=True):
            row |= {"holm_p": p, "verdict": _verdict(row, p)}
    flat = tuple(row for family in rows.values() for row in family)
    return Table(flat, _columns(keys)) if flat else None


def _paired_errors(
    reference: Sequence[TrialResult], rival: Sequence[TrialResult]
) -> list[tuple[float, float]]:
    """Errors [m] of the two in every world that both have tracked; arms that know it have none."""
    first, second = (
        {world_of(r): r.track_rmse_m for r in rows if r.track_rmse_m} for rows in (reference, rival)
    )
    return [(first[world], second[world]) for world in first if world in second]


def _measures(pairs: Sequence[tuple[float, float]]) -> TableRow:
    closer = sum(a < b for a, b in pairs)
    wider = sum(a > b for a, b in pairs)
    ratio = math.exp(sum(math.log(b / a) for a, b in pairs) / len(pairs))
    return {
        "n": len(pairs),
        "first_rmse_m": median(a for a, _ in pairs),
        "second_rmse_m": median(b for _, b in pairs),
        "ratio": ratio,
        "closer": closer,
        "wider": wider,
        "sign_p": mcnemar_exact(closer, wider),
    }


def _verdict(row: TableRow, p: float) -> str:
    if p >= SIGNIFICANCE:
        return "undecided"
    return "closer" if row["closer"] > row["wider"] else "wider"


def _columns(keys: Sequence[str]) -> tuple[Column, ...]:
    return (
        *key_columns(keys),
        Column("n", lambda row: str(row["n"])),
        Column(f"RMSE {REFERENCE_TRACKER} [mm]", lambda row: f"{1e3 * row['first_rmse_m']:.2f}"),
        Column("RMSE tracker [mm]", lambda row: f"{1e3 * row['second_rmse_m']:.2f}"),
        Column("ratio", lambda row: f"{row['ratio']:.2f}"),
        Column(f"{REFERENCE_TRACKER} closer in", lambda row: str(row["closer"])),
        Column("sign test p", lambda row: show_p(row["sign_p"])),
        Column("Holm p", lambda row: show_p(row["holm_p"])),
        Column(f"{REFERENCE_TRACKER} is", lambda row: row["verdict"]),
    )
