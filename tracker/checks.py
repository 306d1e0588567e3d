"""What the settings of the trackers may be: one line that names the bad value and the good ones."""

import difflib
import math
from collections.abc import Collection


def require_positive(config: object, *names: str) -> None:
    """ValueError for a field of `config` that is not a finite number above zero."""
    for name in names:
        value = getattr(config, name)
        if not (math.isfinite(value) and value > 0):
            raise ValueError(f"{name} must be a positive number, got {value!r}")


def require_share(config: object, *names: str) -> None:
    """ValueError for a field of `config` that is not from 0 to 1."""
    for name in names:
        value = getattr(config, name)
        if not 0.0 <= value <= 1.0:
            raise ValueError(f"{name} must be in [0, 1], got {value!r}")


def require_count(config: object, *names: str, least: int = 1) -> None:
    """ValueError for a field of `config` below `least`."""
    for name in names:
        value = getattr(config, name)
        if value < least:
            raise ValueError(f"{name} must be {least} or greater, got {value}")


def require_choice(config: object, name: str, choices: Collection[str]) -> None:
    """ValueError for a field of `config` that is none of `choices`."""
    require_known(name, getattr(config, name), choices)


def require_known(kind: str, value: str, valid: Collection[str]) -> None:
    """ValueError for a `value` that is not in `valid`; it lists these and suggests the nearest.

    `kind` says in the message what the value names: a tracker, a predictor, a field of settings.
    """
    if value in valid:
        return
    near = difflib.get_close_matches(str(value), valid, n=1)
    suggestion = f"; did you mean {near[0]!r}?" if near else ""
    raise ValueError(f"{kind} must be one of {', '.join(valid)}; got {value!r}{suggestion}")
