"""Checks of what a user gives: each error is one line that names the bad value and the valid ones.

Light to import, as the command line needs them.
"""

import difflib
import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

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


def require(
    config: object, valid: str, is_valid: Callable[[Any], bool], names: Iterable[str]
) -> None:
    """Raises ValueError for a field of `config` that is not valid; `valid` says what would be."""
    for name in names:
        if not is_valid(value := getattr(config, name)):
            raise ValueError(f"{name} must be {valid}, got {value!r}")


def require_within(config: object, low: float, high: float, *names: str) -> None:
    """Raises ValueError for a field of `config` that is not a number from `low` to `high`."""
    require(config, f"a number from {low:g} to {high:g}", lambda v: low <= v <= high, names)


def require_positive(config: object, *names: str) -> None:
    """Raises ValueError for a field of `config` that is not a finite number above 0."""
    require(config, "a positive number", lambda v: math.isfinite(v) and v > 0.0, names)


def require_at_least(config: object, low: float, *names: str) -> None:
    """Raises ValueError for a field of `config` that is not a finite number of `low` or more."""
    require(config, f"{low:g} or greater", lambda v: math.isfinite(v) and v >= low, names)
