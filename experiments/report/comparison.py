"""Placeholder until the general comparison is merged."""

from __future__ import annotations

from typing import Any


def comparison_lines(first: Any, second: Any, name: str, *, higher_is_better: bool) -> list[str]:
    """The lines of a comparison."""
    raise ValueError(f"not yet: {first} {second} {name} {higher_is_better}")
