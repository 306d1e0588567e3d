"""How far a long command has come."""

from __future__ import annotations

import sys
from typing import Any

from tqdm import tqdm


def progress_bar(description: str, unit: str, total: int, done: int = 0) -> tqdm[Any]:
    """A bar with the time left; in a log file a line now and then instead of a live one."""
    return tqdm(
        total=total,
        initial=done,
        desc=description,
        unit=unit,
        smoothing=0.1,
        file=sys.stderr,
        mininterval=0.5 if sys.stderr.isatty() else 15.0,
    )
