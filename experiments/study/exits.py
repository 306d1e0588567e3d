"""How a command ends: its exit codes, and what Ctrl-C leaves."""

from __future__ import annotations

import sys
from pathlib import Path

CRASH_EXIT = 1
"""Something that was asked for is missing from the results."""
USAGE_EXIT = 2
"""What the user got wrong."""
INTERRUPT_EXIT = 130
"""Ctrl-C."""


def tell_interrupted(folder: Path) -> int:
    """Says that nothing finished is lost; the exit code."""
    print(
        f"beltgrasp: stopped; what is finished is kept in {folder}, and the same command resumes",
        file=sys.stderr,
    )
    return INTERRUPT_EXIT
