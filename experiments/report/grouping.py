"""Cells and worlds: which trials belong together, and what people call them."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from typing import Any, TypeAlias, TypeVar

from experiments.belt.config import TrialConfig, TrialResult

Row = TypeVar("Row")

World: TypeAlias = tuple[Any, ...]
"""What a trial met, whoever tracked: the setting and the seed."""

_FIELDS = tuple(field.name for field in dataclasses.fields(TrialConfig))

SETTING = tuple(
    name for name in _FIELDS if name not in ("tracker", "seed", "particle_count", "error_threshold")
)
"""Columns that name what a trial met, except the seed: all that is not the tracker's own."""

USUAL_KEYS = ("tracker", "camera", "condition", "speed_mps")
"""Columns that name a cell in every table; the others do where they vary."""

_HEADINGS = {
    "speed_mps": "speed [m/s]",
    "delay_s": "delay [s]",
    "camera_rate_hz": "camera [Hz]",
    "gripper_delay_s": "gripper delay [s]",
    "particle_count": "particles",
    "error_threshold": "threshold [m]",
}

_UNITS = {
    "speed_mps": "m/s",
    "delay_s": "s delay",
    "camera_rate_hz": "Hz",
    "gripper_delay_s": "s gripper delay",
    "particle_count": "particles",
    "error_threshold": "m threshold",
}


def cell_keys(results: Sequence[TrialResult]) -> list[str]:
    """Columns that name a cell: the usual four, and others that vary in these results."""
    others = (name for name in _FIELDS if name != "seed" and name not in USUAL_KEYS)
    varying = [key for key in others if len({getattr(row, key) for row in results}) > 1]
    return [*USUAL_KEYS[:3], *varying, USUAL_KEYS[3]]


def group_by(results: Iterable[Row], keys: Sequence[str]) -> dict[tuple[Any, ...], list[Row]]:
    """Rows by the values of `keys`, in order of first appearance."""
    groups: dict[tuple[Any, ...], list[Row]] = {}
    for row in results:
        groups.setdefault(tuple(getattr(row, key) for key in keys), []).append(row)
    return groups


def world_of(row: TrialResult) -> World:
    """The world that a trial met."""
    return (*(getattr(row, name) for name in SETTING), row.seed)


def heading(key: str) -> str:
    """A column's name for people, with its unit."""
    return _HEADINGS.get(key, key)


def show_key(value: str | float) -> str:
    """A value that names a cell: a name as it is, a number in as few digits as tell it apart."""
    if isinstance(value, str | int):
        return str(value)
    return f"{value:.2f}" if 0.1 <= value < 10.0 else f"{value:.3g}"


def label(key: str, value: str | float) -> str:
    """A value that names a cell, with its unit where it stands alone."""
    return f"{show_key(value)} {_UNITS[key]}" if key in _UNITS else show_key(value)
