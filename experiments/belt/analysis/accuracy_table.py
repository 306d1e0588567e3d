"""Who sees the target more exactly on the same worlds, whatever became of the grasp."""

import math
from collections.abc import Sequence
from statistics import median

from experiments.belt.analysis.cells import condition_keys, key_columns, world_of
from experiments.belt.analysis.paired_tables import REFERENCE_TRACKER, rivals
from experiments.belt.config import TrialResult
from experiments.report.statistics import SIGNIFICANCE, holm, mcnemar_exact
from experiments.report.table import Table, TableRow, number, p_value, word, words


def accuracy_table(results: Sequence[TrialResult]) -> Table:
    """Returns a row for each rival and condition, all speeds together; no rows without pairs.

    In each world that both have tracked the smaller error of the tracked position wins; the p is
    the exact sign test's [Dixon1946], and Holm's over the conditions of a rival [Holm1979]. The
    ratio is the geometric mean of the rival's error over the reference's.
    """
    keys = condition_keys(results)
    families: dict[object, list[TableRow]] = {}
    for names, reference, members in rivals(results, keys):
        if pairs := _paired_errors(reference, members):
            families.setdefault(names["tracker"], []).append(names | _measures(pairs))
    for family in families.values():
        for row, p in zip(family, holm([row["sign_p"] for row in family]), strict=True):
            row |= {"holm_p": p, "verdict": _verdict(row, p)}
    columns = (
        *key_columns(keys),
        *words("n"),
        number(f"RMSE {REFERENCE_TRACKER} [mm]", "first_rmse_m", factor=1e3),
        number("RMSE tracker [mm]", "second_rmse_m", factor=1e3),
        number("ratio", "ratio"),
        word(f"{REFERENCE_TRACKER} closer in", "closer"),
        p_value("sign test p", "sign_p"),
        p_value("Holm p", "holm_p"),
        word(f"{REFERENCE_TRACKER} is", "verdict"),
    )
    return Table([row for family in families.values() for row in family], columns)


def _paired_errors(
    reference: Sequence[TrialResult], rival: Sequence[TrialResult]
) -> list[tuple[float, float]]:
    """Returns the errors [m] of the two in every world that both have tracked."""
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
