"""What commands make of the flags that several of them have."""

from __future__ import annotations

import os
from collections.abc import Iterable


def split_names(values: Iterable[str]) -> tuple[str, ...]:
    """The words in the values, each once; commas are as good as spaces."""
    return tuple(
        dict.fromkeys(word for value in values for word in value.replace(",", " ").split())
    )


def seed_range(count: int, first: int = 0) -> range:
    """So many seeds from the first on."""
    if count < 1:
        raise ValueError(f"seeds must be 1 or greater, got {count}")
    if first < 0:
        raise ValueError(f"first-seed must be 0 or greater, got {first}")
    return range(first, first + count)


def worker_count(wanted: int | None) -> int:
    """The wanted number of processes, or one for each processor that this one may use."""
    if wanted is not None:
        return wanted
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
