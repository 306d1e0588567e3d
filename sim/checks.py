"""Checks of what a user gives: each error is one line that names the bad value and the valid ones.

Light to import, as the command line needs them.
"""

import difflib
import math
from collections.abc import Mapping
from typing import TypeVar

Entry = TypeVar("Entry")


def look_up(kind: str, name: str, registry: Mapping[str, Entry]) -> Entry:
    """Returns the entry of that name; ValueError lists the valid names and suggests the nearest.

    Args:
        kind: What the names stand for, as `camera`.
        name: As a user wrote it.
        registry: Every valid name with its entry.
    """
    if name in registry:
        return registry[name]
    near = difflib.get_close_matches(name, list(registry), n=1)
    suggestion = f"; did you mean {near[0]!r}?" if near else ""
    raise ValueError(f"{kind} must be one of {', '.join(registry)}; got {name!r}{suggestion}")


def require_within(config: object, low: float, high: float, *names: str) -> None:
    """Raises ValueError for a field of `config` that is not a number from `low` to `high`."""
    for name in names:
        value = getattr(config, name)
        if not low <= value <= high:
            raise ValueError(f"{name} must be a number from {low:g} to {high:g}, got {value!r}")


def require_positive(config: object, *names: str) -> None:
    """Raises ValueError for a field of `config` that is not a finite number above 0."""
    for name in names:
        value = getattr(config, name)
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} must be a positive number, got {value!r}")


def require_at_least(config: object, low: float, *names: str) -> None:
    """Raises ValueError for a field of `config` that is not a finite number of `low` or more."""
    for name in names:
        value = getattr(config, name)
        if not (math.isfinite(value) and value >= low):
            raise ValueError(f"{name} must be {low:g} or greater, got {value!r}")
