"""Cells, settings and worlds of a sweep: which trials belong together, and what people call them.

A cell is all that determines a trial except the seed, a setting is a cell without its tracker, and
a world is a setting with a seed.
"""

import dataclasses
from collections.abc import Sequence
from typing import Any, TypeAlias

from experiments.belt.config import TrialConfig, TrialResult
from experiments.report.grouping import group_by, varying
from experiments.report.table import Column

World: TypeAlias = tuple[Any, ...]
"""What a trial met, whoever tracked: the setting and the seed."""

_FIELDS = tuple(
    field.name
    for field in dataclasses.fields(TrialResult)
    if field.name in TrialConfig.__dataclass_fields__
)

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
    """Returns the columns that name a cell: the usual four, and others that vary in the results."""
    others = [name for name in _FIELDS if name != "seed" and name not in USUAL_KEYS]
    return [*USUAL_KEYS[:3], *varying(results, others), USUAL_KEYS[3]]


def condition_keys(results: Sequence[TrialResult]) -> list[str]:
    """Returns the columns that name a cell whose trials at all belt speeds count together."""
    return [key for key in cell_keys(results) if key != "speed_mps"]


def world_of(row: TrialResult) -> World:
    """Returns the world that a trial met."""
    return (*(getattr(row, name) for name in SETTING), row.seed)


def settings_of(
    results: Sequence[TrialResult], keys: Sequence[str]
) -> dict[str, list[TrialResult]]:
    """Groups results by everything that names a cell except tracker and speed, under a title.

    The title names what varies; all of it where nothing does.
    """
    names = [key for key in keys if key not in ("tracker", "speed_mps")]
    titled = varying(results, names) or names
    return {
        title_of(titled, [setting[names.index(key)] for key in titled]): members
        for setting, members in group_by(results, names).items()
    }


def trackers_of(results: Sequence[TrialResult]) -> list[str]:
    """Returns the trackers in order of first appearance."""
    return list(dict.fromkeys(row.tracker for row in results))


def cell_sizes(results: Sequence[TrialResult]) -> str:
    """Returns the number of trials behind each value of a figure, in words."""
    sizes = {len(members) for members in group_by(results, cell_keys(results)).values()}
    return f"n = {min(sizes)}" + (f" to {max(sizes)}" if len(sizes) > 1 else "")


def key_columns(keys: Sequence[str]) -> list[Column]:
    """Returns the columns of a table that name a cell."""
    return [
        Column(_HEADINGS.get(key, key), lambda row, key=key: show_key(row[key])) for key in keys
    ]


def show_key(value: str | float) -> str:
    """Shows a value that names a cell: a name as it is, a number in as few digits as distinct."""
    if isinstance(value, str | int):
        return str(value)
    return f"{value:.2f}" if 0.1 <= value < 10.0 else f"{value:.3g}"


def label(key: str, value: str | float) -> str:
    """Shows a value that names a cell, with its unit where it stands alone."""
    return f"{show_key(value)} {_UNITS[key]}" if key in _UNITS else show_key(value)


def title_of(keys: Sequence[str], values: Sequence[Any], between: str = ", ") -> str:
    """Shows the values of several keys, each with its unit."""
    return between.join(label(key, value) for key, value in zip(keys, values, strict=True))
