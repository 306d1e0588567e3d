"""Rows that belong together, whatever they are rows of."""

from collections.abc import Iterable, Sequence
from typing import Any, TypeVar

Row = TypeVar("Row")


def group_by(rows: Iterable[Row], keys: Sequence[str]) -> dict[tuple[Any, ...], list[Row]]:
    """Returns the rows by the values of `keys`, in order of first appearance."""
    groups: dict[tuple[Any, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault(tuple(getattr(row, key) for key in keys), []).append(row)
    return groups


def named_groups(
    rows: Iterable[Row], keys: Sequence[str]
) -> list[tuple[dict[str, Any], list[Row]]]:
    """Returns the groups of `group_by`, each with the values of its keys by name."""
    groups = group_by(rows, keys).items()
    return [(dict(zip(keys, values, strict=True)), members) for values, members in groups]


def varying(rows: Sequence[object], keys: Iterable[str]) -> list[str]:
    """Returns the keys that have more than one value in these rows."""
    return [key for key in keys if len({getattr(row, key) for row in rows}) > 1]
