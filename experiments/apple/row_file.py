"""A CSV of rows in groups, one group for each world: appended as worlds end, sorted at the end.

A group is one write, so that a kill leaves whole groups and at most one torn one, which is cut off
when the file is opened again. Sorted, the file does not depend on the number of workers.
"""

from __future__ import annotations

import csv
import dataclasses
import types
import typing
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, Generic, TypeVar

from experiments.records import append_bytes, csv_line, cut_off, whole_lines, write_whole

Row = TypeVar("Row")


class RowFile(Generic[Row]):
    """Rows of one dataclass; the fields named by `key` tell which group a row is of."""

    def __init__(
        self, path: Path, row_type: type[Row], key: Sequence[str], size: Callable[[Row], int]
    ) -> None:
        """Names the file.

        Args:
            path: The CSV; it need not exist.
            row_type: A frozen dataclass of scalars.
            key: Fields that name a group.
            size: How many rows the group of a row has; by it a torn group is told.
        """
        self.path, self._type, self._key, self._size = path, row_type, tuple(key), size
        self._names = [field.name for field in dataclasses.fields(typing.cast(Any, row_type))]
        self._header = csv_line(self._names)

    def resume(self) -> set[tuple[object, ...]]:
        """Cuts off a torn group and returns the keys of the whole ones."""
        lines = whole_lines(self.path, cut=True)
        if not lines:
            return set()
        rows = self._whole(self._parse(lines))
        cut_off(self.path, len("".join(lines[: 1 + len(rows)]).encode()))
        return {self._key_of(row) for row in rows}

    def append(self, rows: Iterable[Row]) -> None:
        """Adds one group; it is safe from a kill when this returns."""
        text = "".join(map(self._line, rows))
        head = "" if self.path.exists() and self.path.stat().st_size else self._header
        append_bytes(self.path, (head + text).encode())

    def sort(self, order: Callable[[tuple[object, ...]], Any]) -> None:
        """Puts the groups in the order of what `order` makes of their keys."""
        rows = sorted(self.read(), key=lambda row: order(self._key_of(row)))
        write_whole(self.path, self._header + "".join(map(self._line, rows)))

    def read(self) -> list[Row]:
        """All rows of whole groups; ValueError where the file is missing or of other columns."""
        lines = whole_lines(self.path)
        if not lines:
            raise ValueError(f"{self.path} is missing or empty; run the experiment first")
        return self._whole(self._parse(lines))

    def _whole(self, rows: list[Row]) -> list[Row]:
        """The rows without those of a last group that is not whole."""
        start = 0
        while start < len(rows):
            end = start + self._size(rows[start])
            if end > len(rows):
                break
            start = end
        return rows[:start]

    def _parse(self, lines: Sequence[str]) -> list[Row]:
        if lines[0] != self._header:
            raise ValueError(
                f"{self.path} has the columns of another version of beltgrasp; "
                "choose another folder or remove this one"
            )
        hints = typing.get_type_hints(self._type)
        parsers = [_parser(hints[name]) for name in self._names]
        rows: list[Row] = []
        for number, cells in enumerate(csv.reader(lines[1:]), start=2):
            try:
                values = [parse(cell) for parse, cell in zip(parsers, cells, strict=True)]
            except (ValueError, KeyError) as error:
                raise ValueError(f"{self.path}, line {number} is not a row: {error}") from None
            rows.append(self._type(*values))
        return rows

    def _line(self, row: Row) -> str:
        return csv_line(getattr(row, name) for name in self._names)

    def _key_of(self, row: Row) -> tuple[object, ...]:
        return tuple(getattr(row, name) for name in self._key)


def _parser(hint: Any) -> Any:
    if isinstance(hint, types.UnionType):
        parse = _parser(next(arg for arg in typing.get_args(hint) if arg is not type(None)))

        def parse_optional(cell: str) -> Any:
            return None if cell == "" else parse(cell)

        return parse_optional
    return {"true": True, "false": False}.__getitem__ if hint is bool else hint
