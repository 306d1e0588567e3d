"""Rows: dataclasses of scalars as lines of CSV, one schema and one writer for every study."""

import csv
import dataclasses
import types
import typing
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Literal, TypeAlias, TypeVar, cast

from experiments.report.table import csv_line, format_cell

Row = TypeVar("Row")

JobOutcome: TypeAlias = Literal["done", "error"]
"""How a job ended that cannot fail but by a crash."""

_DETAIL_LIMIT = 1000
"""Characters of an error's message in its row; Python reads no cell of more than 131 072."""


def columns(row_type: type[Any]) -> list[str]:
    """The names of a row's fields, in their order."""
    return [field.name for field in dataclasses.fields(row_type)]


def header_line(row_type: type[Any]) -> str:
    """The header of a file of such rows."""
    return csv_line(columns(row_type))


def row_line(row: Any) -> str:
    """The row as one CSV line."""
    return csv_line(getattr(row, name) for name in columns(cast(type[Any], type(row))))


def parse_rows(path: Path, lines: Sequence[str], row_type: type[Row]) -> list[Row]:
    """The typed rows in the lines of a file, the first of which is the header.

    Raises ValueError where the columns are not this version's, or a cell is not of its type.
    """
    if lines[0] != header_line(row_type):
        raise ValueError(f"{path}: {_header_difference(lines[0], row_type)}")
    parsers = _cell_parsers(row_type)
    rows: list[Row] = []
    for number, cells in enumerate(csv.reader(lines[1:]), start=2):
        try:
            values = [parse(cell) for parse, cell in zip(parsers, cells, strict=True)]
        except (ValueError, KeyError) as error:
            raise ValueError(f"{path}, line {number} is not a valid row: {error}") from error
        rows.append(row_type(*values))
    return rows


def to_json(row: Any) -> dict[str, Any]:
    """The row as JSON-ready values, floats rounded as in the CSV; null where no number exists."""
    values = dataclasses.asdict(row)
    for name, value in values.items():
        if isinstance(value, float):
            rounded = float(format_cell(value))
            values[name] = rounded if rounded - rounded == 0.0 else None
    return values


def error_row(row_type: type[Row], known: Mapping[str, Any], detail: str) -> Row:
    """The row of a job that crashed: `outcome` is error and nothing is measured.

    Args:
        row_type: The study's row, with the columns `outcome` and `detail`.
        known: What is known of it; the other columns are None where allowed, else zero.
        detail: The cause in one line; what is longer than a cell may be is cut off.
    """
    known = {**known, "outcome": "error", "detail": detail[:_DETAIL_LIMIT]}
    hints = typing.get_type_hints(row_type)
    return row_type(**{name: known.get(name, _empty(hint)) for name, hint in hints.items()})


def _empty(hint: Any) -> object:
    if _is_optional(hint):
        return None
    return hint() if hint in (bool, int, float, str) else ""


def _is_optional(hint: Any) -> bool:
    return isinstance(hint, types.UnionType) and type(None) in typing.get_args(hint)


@cache
def _cell_parsers(row_type: type) -> tuple[Any, ...]:
    """One function from text to value for each field."""
    return tuple(_parser(hint) for hint in typing.get_type_hints(row_type).values())


def _parser(hint: Any) -> Any:
    if _is_optional(hint):
        parse = _parser(next(arg for arg in typing.get_args(hint) if arg is not type(None)))

        def parse_optional(cell: str) -> Any:
            return None if cell == "" else parse(cell)

        return parse_optional
    if hint is bool:
        return {"true": True, "false": False}.__getitem__
    if typing.get_origin(hint) is typing.Literal:
        return {choice: choice for choice in typing.get_args(hint)}.__getitem__
    return hint


def _header_difference(header: str, row_type: type[Any]) -> str:
    found, expected = next(csv.reader([header])), columns(row_type)
    missing = ", ".join(name for name in expected if name not in found) or "none"
    unknown = ", ".join(name for name in found if name not in expected) or "none"
    return (
        "the columns are those of another version of beltgrasp "
        f"(missing: {missing}; unknown: {unknown}); use a new folder"
    )
