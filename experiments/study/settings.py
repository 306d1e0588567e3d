"""What determines a row beside its job: settings by name, kept so that they can be compared.

A results folder keeps the settings of all its rows in the manifest. The same command with other
settings is refused with what differs, so that no table shows two methods under one name.
"""

import dataclasses
import enum
import functools
import hashlib
import inspect
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeAlias, cast

import numpy as np

Settings: TypeAlias = dict[str, Any]
"""Name of what is set -> its description, as JSON holds it."""

_NAMED = 4
"""As many differences are named in a message."""
_OWN = {"sim", "tracker", "experiments"}
"""Packages of the project, of which the commit tells the source."""


def describe(value: object) -> Any:
    """Everything in a value that can change a result, as JSON holds it.

    Dataclasses and mappings become mappings; arrays and files are hashed; of a function or class
    the import path counts. ValueError for an object whose values are not known.
    """
    if isinstance(value, np.generic):
        return describe(cast(Any, value).item())
    if isinstance(value, enum.Enum):
        return value.name
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, Path):
        return digest(value.read_bytes())
    if isinstance(value, np.ndarray):
        array: Any = np.ascontiguousarray(cast(Any, value))
        return f"{array.shape} {digest(array.tobytes())}"
    if isinstance(value, functools.partial):
        part = cast("functools.partial[Any]", value)
        return [describe(part.func), describe(part.args), describe(part.keywords)]
    if inspect.isroutine(value) or inspect.isclass(value):
        return _describe_callable(value)
    if dataclasses.is_dataclass(value):
        names = [field.name for field in dataclasses.fields(value) if field.name != "description"]
        return {name: describe(getattr(value, name)) for name in names}
    if isinstance(value, Mapping):
        return {str(k): describe(v) for k, v in cast(Mapping[Any, Any], value).items()}
    if isinstance(value, set | frozenset):
        return sorted(map(describe, cast(set[Any], value)), key=json.dumps)
    if isinstance(value, Iterable):
        return [describe(item) for item in cast(Iterable[Any], value)]
    raise ValueError(f"settings must be data, files or functions, got {value!r}")


def _describe_callable(value: Any) -> str:
    """The name of a function or class and, of one from outside the project, its source."""
    if value.__module__.partition(".")[0] in _OWN:
        return value.__qualname__
    try:
        return f"{value.__qualname__} {digest(inspect.getsource(value).encode())}"
    except (OSError, TypeError):
        return f"{value.__module__}.{value.__qualname__}"


def merge(kept: Settings, wanted: Mapping[str, object]) -> Settings:
    """The kept settings and those that are new among the wanted ones.

    Raises ValueError that says what differs where both name the same thing.
    """
    described = {name: describe(value) for name, value in wanted.items()}
    differing = [
        f"{name}{difference}"
        for name, value in described.items()
        for difference in _differences(kept.get(name, value), value)
    ]
    if differing:
        more = f" and {len(differing) - _NAMED} more" if len(differing) > _NAMED else ""
        raise ValueError(f"other settings: {'; '.join(differing[:_NAMED])}{more}")
    return kept | described


def _differences(kept: Any, wanted: Any) -> list[str]:
    """Where two descriptions differ, and how."""
    if kept == wanted:
        return []
    if isinstance(kept, dict) and isinstance(wanted, dict):
        old, new = cast(Settings, kept), cast(Settings, wanted)
        return [
            f".{name}{difference}"
            for name in dict.fromkeys([*old, *new])
            for difference in _differences(old.get(name), new.get(name))
        ]
    return [f" was {kept}, is {wanted}"]


def digest(data: bytes) -> str:
    """A short hash of what is too long to be kept in a manifest."""
    return hashlib.sha256(data).hexdigest()[:16]
