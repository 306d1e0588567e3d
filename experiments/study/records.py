"""One schema, one writer: trials.csv and timings.csv have the fields of their dataclasses.

A row is one physical line, written by one call and synced, so that a kill leaves at most one torn
last line, which has no line end and is cut off before the next row is written.
"""

from __future__ import annotations

import contextlib
import csv
import dataclasses
import io
import os
import types
import typing
from collections.abc import Generator, Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

from experiments.belt.config import TrialConfig, TrialResult, TrialTimings

Row = TypeVar("Row")

_DETAIL_LIMIT = 1000
"""Characters of an error's message in its row; Python reads no cell of more than 131 072."""


def format_cell(value: object) -> str:
    """One scalar as text: empty for None, true or false, 9 significant digits for a float."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return format(value + 0.0, ".9g")
    if isinstance(value, int):
        return str(value)
    if isinstance(value, str):
        return " ".join(value.split()).encode(errors="backslashreplace").decode()
    raise TypeError(f"a cell holds one scalar, got {type(value).__name__}")


def csv_line(cells: Iterable[object]) -> str:
    """The cells as one CSV line with its line end."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow([format_cell(cell) for cell in cells])
    return text.getvalue()


def header_line(row_type: type[Any]) -> str:
    """The header: the names of the fields, in their order."""
    return csv_line(field.name for field in dataclasses.fields(row_type))


def row_line(row: Any) -> str:
    """The row as the bytes that `append_line` writes."""
    return csv_line(getattr(row, field.name) for field in dataclasses.fields(row))


def append_line(path: Path, line: str) -> None:
    """Adds one whole line by a single write and waits until it is on the disk."""
    append_bytes(path, line.encode())


def append_bytes(path: Path, data: bytes) -> None:
    """Adds bytes by a single write and waits until they are on the disk."""
    with _naming(path):
        descriptor = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o666)
        try:
            while data:  # a disk that takes a part says why at the rest
                data = data[os.write(descriptor, data) :]
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def cut_off(path: Path, end: int) -> None:
    """Takes away what a file holds from that byte on."""
    if end < path.stat().st_size:
        with _naming(path):
            os.truncate(path, end)


def write_whole(path: Path, content: str | bytes) -> None:
    """Replaces the file in one step, so that a kill leaves the old or the new one, whole."""
    new = path.with_name(f".{path.name}.new")
    with _naming(path):
        with new.open("wb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(new, path)


@contextlib.contextmanager
def _naming(path: Path) -> Generator[None, None, None]:
    """What the system has against the writing is told with the name of the file."""
    try:
        yield
    except OSError as error:
        raise OSError(f"cannot write {path}: {error.strerror}") from error


def append_row(path: Path, row: TrialResult | TrialTimings) -> None:
    """Adds one row, and the header before the first one; a torn last line is cut off first."""
    if not whole_lines(path, cut=True):
        append_line(path, header_line(type(row)))
    append_line(path, row_line(row))


def whole_lines(path: Path, *, cut: bool = False) -> list[str]:
    """Complete lines of a file that may not exist; with `cut`, a torn last line is removed."""
    if not path.exists():
        return []
    data = path.read_bytes()
    end = data.rfind(b"\n") + 1
    if cut:
        cut_off(path, end)
    return [line + "\n" for line in data[:end].decode().split("\n")[:-1]]


def keep_lines(path: Path, header: str, count: int) -> None:
    """Leaves so many lines behind the header, which a new file gets."""
    lines = whole_lines(path)[: 1 + count]
    if lines:
        cut_off(path, len("".join(lines).encode()))
    else:
        write_whole(path, header)


def read_rows(path: Path, row_type: type[Row], writer: str = "sweep") -> list[Row]:
    """All complete rows, typed; raises ValueError where the columns are not this version's.

    Args:
        path: The CSV.
        row_type: A dataclass of scalars.
        writer: The command that writes such a file.
    """
    lines = whole_lines(path)
    if not lines:
        raise ValueError(f"{path} is missing or empty; `beltgrasp {writer}` writes it")
    return parse_rows(path, lines, row_type)


def parse_rows(path: Path, lines: Sequence[str], row_type: type[Row]) -> list[Row]:
    """The rows in the lines of a file, the first of which is the header; errors as `read_rows`."""
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


def to_json(row: TrialResult | TrialTimings) -> dict[str, Any]:
    """The row as JSON-ready values, floats rounded as in the CSV; null where no number exists."""
    values = dataclasses.asdict(row)
    for name, value in values.items():
        if isinstance(value, float):
            rounded = float(format_cell(value))
            values[name] = rounded if rounded - rounded == 0.0 else None
    return values


def error_result(config: TrialConfig, detail: str, provenance: Mapping[str, str]) -> TrialResult:
    """The row of a trial that crashed: outcome=error and nothing measured.

    Args:
        config: What was attempted.
        detail: The cause in one line; what is longer than a cell may be is cut off.
        provenance: `preset`, `commit` and `mujoco_version`.
    """
    known: dict[str, Any] = dataclasses.asdict(config) | {"trial_id": config.trial_id}
    known |= {"outcome": "error", "detail": detail[:_DETAIL_LIMIT]} | dict(provenance)
    return _blank(TrialResult, known)


def error_timings(config: TrialConfig, wall_s: float) -> TrialTimings:
    """The timings of a trial that crashed: how long it took, and nothing else."""
    return _blank(TrialTimings, {"trial_id": config.trial_id, "wall_s": wall_s})


def _blank(row_type: type[Row], known: Mapping[str, Any]) -> Row:
    """A row with the known values; the others are None where allowed, else zero of their type."""
    hints = typing.get_type_hints(row_type)
    values = {name: known.get(name, _empty_value(hint)) for name, hint in hints.items()}
    return row_type(**values)


def _empty_value(hint: Any) -> object:
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
    found = next(csv.reader([header]))
    expected = [field.name for field in dataclasses.fields(row_type)]
    missing = ", ".join(name for name in expected if name not in found) or "none"
    unknown = ", ".join(name for name in found if name not in expected) or "none"
    return (
        "the columns are those of another version of beltgrasp "
        f"(missing: {missing}; unknown: {unknown}); use a new folder"
    )
