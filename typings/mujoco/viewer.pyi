"""The package is untyped: whatever it hands out may be anything."""

from typing import Any

def __getattr__(name: str) -> Any: ...
