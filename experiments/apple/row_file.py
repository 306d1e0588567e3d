"""A CSV of rows in groups, one group for each world: appended as worlds end, sorted at the end.

A group is one write, so that a kill leaves whole groups and at most one torn one, which is cut off
when the file is opened again. Sorted, the file does not depend on the number of workers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, Generic, TypeVar

from experiments.study.records import (
    append_bytes,
    cut_off,
    header_line,
    parse_rows,
    read_rows,
    row_line,
    whole_lines,
    write_whole,
)

Row = TypeVar("Row")


class RowFile(Generic[Row]):
    """Rows of one dataclass; the fields named by `key` tell which group a row is of."""

    def __init__(
        self, path: Path, row_type: type[Row], key: Sequence[str], size: Callable[[Row], int]
    ) -> None:
        """Names the file.

        Args:
            path: The CSV, named after the command that writes it; it need not exist.
            row_type: A frozen dataclass of scalars.
            key: Fields that name a group.
            size: How many rows the group of a row has; by it a torn group is told.
        """
        self.path, self._type, self._key, self._size = path, row_type, tuple(key), size

    def resume(self) -> set[tuple[object, ...]]:
        """Cuts off a torn group and returns the keys of the whole ones."""
        lines = whole_lines(self.path, cut=True)
        if not lines:
            return set()
        rows = self._whole(parse_rows(self.path, lines, self._type))
        cut_off(self.path, len("".join(lines[: 1 + len(rows)]).encode()))
        return {self._key_of(row) for row in rows}

    def append(self, rows: Iterable[Row]) -> None:
        """Adds one group; it is safe from a kill when this returns."""
        text = "".join(map(row_line, rows))
        head = "" if self.path.exists() and self.path.stat().st_size else header_line(self._type)
        append_bytes(self.path, (head + text).encode())

    def sort(self, order: Callable[[tuple[object, ...]], Any]) -> None:
        """Puts the groups in the order of what `order` makes of their keys."""
        rows = sorted(self.read(), key=lambda row: order(self._key_of(row)))
        write_whole(self.path, header_line(self._type) + "".join(map(row_line, rows)))

    def read(self) -> list[Row]:
        """All rows of whole groups; ValueError where the file is missing or of other columns."""
        return self._whole(read_rows(self.path, self._type, f"apple {self.path.stem}"))

    def _whole(self, rows: list[Row]) -> list[Row]:
        """The rows without those of a last group that is not whole."""
        start = 0
        while start < len(rows):
            end = start + self._size(rows[start])
            if end > len(rows):
                break
            start = end
        return rows[:start]

    def _key_of(self, row: Row) -> tuple[object, ...]:
        return tuple(getattr(row, name) for name in self._key)
