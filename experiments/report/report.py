"""What a report leaves: files, and the tables as text for a terminal."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from experiments.report.table import Table, write_tables


@dataclass(frozen=True)
class Report:
    """The text of a report for a terminal, and the files that were written."""

    text: str
    paths: tuple[Path, ...]

    @classmethod
    def of(
        cls,
        folder: Path,
        tables: Mapping[str, Table],
        figures: Iterable[Path],
        shown: Sequence[str] = (),
        notes: Sequence[str] = (),
    ) -> Self:
        """Writes the tables that have rows into `folder/tables` and returns the report on all.

        Args:
            folder: The results folder.
            tables: All tables by the name of their files.
            figures: Paths of the figures, which have been written.
            shown: Names of the tables that the text holds; all of them if none is given.
            notes: Lines behind the tables, such as what could not be made.
        """
        paths = write_tables(folder / "tables", tables)
        names = [name for name in shown or tables if name in tables and tables[name].rows]
        text = "\n".join([*(tables[name].to_text() for name in names), *notes])
        return cls(text, (*paths, *figures))

    def show(self) -> None:
        """Prints the tables, and the files."""
        print(self.text)
        print("\n".join(f"written: {path}" for path in self.paths))
