"""A report: the tables and figures that were written, and what a terminal shows of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from experiments.report.table import Table, write_tables


@dataclass(frozen=True)
class Report:
    """What was written, and the tables as text for a terminal."""

    text: str
    paths: tuple[Path, ...]

    def show(self) -> None:
        """Prints the tables, and the files."""
        print(self.text)
        print("\n".join(f"written: {path}" for path in self.paths))


def write_report(
    folder: Path,
    tables: Mapping[str, Table | None],
    figures: Iterable[Path],
    shown: Sequence[str] = (),
    notes: Iterable[str] = (),
) -> Report:
    """Writes the tables of a results folder, and puts the report together.

    Args:
        folder: The results folder; tables go into `tables/`.
        tables: Name of the file -> table; None where there is nothing to show.
        figures: Files that were drawn.
        shown: Names of the tables that a terminal shows; all where empty.
        notes: Lines about what could not be made.
    """
    made = {name: table for name, table in tables.items() if table is not None and table.rows}
    paths = write_tables(folder / "tables", made)
    text = [made[name].to_text() for name in (shown or made) if name in made]
    return Report("\n".join([*text, *notes]), (*paths, *figures))
