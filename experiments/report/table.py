"""A table as people see it: in Markdown, LaTeX and a terminal; and as programs do: in CSV."""

import csv
import io
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self, TypeAlias

TableRow: TypeAlias = dict[str, Any]


@dataclass(frozen=True)
class Column:
    """One column of a table for people; the CSV holds the raw values instead."""

    label: str
    show: Callable[[TableRow], str]


@dataclass(frozen=True)
class Table:
    """Raw rows, and how people see them; a table without rows is not written."""

    rows: Sequence[TableRow]
    columns: Sequence[Column]

    @classmethod
    def of(cls, rows: Sequence[TableRow], *columns: Column) -> Self:
        """Returns the table of these rows with these columns."""
        return cls(rows, columns)

    def to_csv(self) -> str:
        """Returns every raw value, a scalar a cell; ValueError where rows differ in their keys."""
        head = self.rows[0].keys()
        for row in self.rows:
            if row.keys() != head:
                raise ValueError(
                    f"every row of a table must have the columns {', '.join(head)}; "
                    f"got {', '.join(row)}"
                )
        return csv_line(head) + "".join(csv_line([row[key] for key in head]) for row in self.rows)

    def to_markdown(self) -> str:
        """Returns the shown columns as a Markdown table."""
        labels, *body = self._shown()
        lines = [labels, ["---"] * len(labels), *body]
        return "".join("| " + " | ".join(cells) + " |\n" for cells in lines)

    def to_text(self) -> str:
        """Returns the shown columns for a terminal: words to the left, numbers to the right."""
        cells = self._shown()
        widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
        is_word = _are_words(cells)
        lines = [
            "  ".join(
                cell.ljust(width) if word else cell.rjust(width)
                for cell, width, word in zip(row, widths, is_word, strict=True)
            ).rstrip()
            for row in cells
        ]
        lines.insert(1, "  ".join("-" * width for width in widths))
        return "\n".join(lines) + "\n"

    def to_latex(self) -> str:
        """Returns the shown columns as a `tabular` for the package booktabs."""
        labels, *rows = self._shown()
        columns = "".join("l" if word else "r" for word in _are_words([labels, *rows]))
        lines = [
            rf"\begin{{tabular}}{{{columns}}}",
            r"\toprule",
            _latex_line(labels),
            r"\midrule",
            *map(_latex_line, rows),
            r"\bottomrule",
            r"\end{tabular}",
        ]
        return "\n".join(lines) + "\n"

    def write(self, folder: Path, name: str) -> list[Path]:
        """Writes NAME.csv, NAME.md and NAME.tex."""
        folder.mkdir(parents=True, exist_ok=True)
        texts = {"csv": self.to_csv(), "md": self.to_markdown(), "tex": self.to_latex()}
        for end, text in texts.items():
            (folder / f"{name}.{end}").write_text(text, encoding="utf-8")
        return [folder / f"{name}.{end}" for end in texts]

    def _shown(self) -> list[list[str]]:
        head = [column.label for column in self.columns]
        return [head, *([column.show(row) for column in self.columns] for row in self.rows)]


def write_tables(folder: Path, tables: Mapping[str, Table]) -> list[Path]:
    """Writes every table that has rows in every format under its name, and returns the paths."""
    return [
        path for name, table in tables.items() if table.rows for path in table.write(folder, name)
    ]


def format_cell(value: object) -> str:
    """One scalar as text: empty for None, true or false, 9 significant digits for a float."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return format(value + 0.0, ".9g")
    if isinstance(value, int):
        return str(value)
    if isinstance(value, str):
        return " ".join(value.split()).encode(errors="backslashreplace").decode()
    raise TypeError(f"a cell holds one scalar, got {type(value).__name__}")


def csv_line(cells: Iterable[object]) -> str:
    """The cells as one CSV line with its line end."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow([format_cell(cell) for cell in cells])
    return text.getvalue()


def words(*keys: str) -> list[Column]:
    """Returns columns that show values as they are, under the names of their keys."""
    return [word(key, key) for key in keys]


def word(label: str, key: str) -> Column:
    """Returns a column that shows a value as it is, and a dash where there is none."""
    return Column(label, lambda row: "-" if row[key] is None else str(row[key]))


def number(label: str, key: str, digits: int = 2, factor: float = 1.0) -> Column:
    """Returns a column of numbers, each multiplied by `factor` for people."""
    return Column(label, lambda row: show_number(row[key], digits, factor))


def rate(label: str, key: str) -> Column:
    """Returns a column of rates, which are shown in percent."""
    return number(label, key, 1, 100.0)


def numbers(shown: Iterable[tuple[str, str, int]]) -> list[Column]:
    """Returns a column of numbers for each (key, label, digits)."""
    return [number(label, key, digits) for key, label, digits in shown]


def interval(
    label: str, *keys: str, digits: int = 2, factor: float = 1.0, sign: str = ""
) -> Column:
    """Returns a column of `value [low, high]` of three keys, or of `[low, high]` of two.

    A cell without bounds shows the value alone, and a dash where there is no value either.

    Args:
        label: The column's heading.
        *keys: Keys of the value, which may be missing, and of its two bounds.
        digits: Digits behind the point.
        factor: What people see is the value times this.
        sign: `+` to show the sign of positive numbers too.
    """

    def show(row: TableRow) -> str:
        *value, low, high = (show_number(row[key], digits, factor, sign) for key in keys)
        has_bounds = row[keys[-1]] is not None
        return " ".join([*value, f"[{low}, {high}]"] if has_bounds else value or ["-"])

    return Column(label, show)


def p_value(label: str, key: str) -> Column:
    """Returns a column of p-values."""
    return Column(label, lambda row: show_p(row[key]))


_NUMBER = re.compile(r"-|[<>]?\s*[+-]?\d.*")
_LATEX = str.maketrans(
    {c: rf"\{c}" for c in "&%$#_{}"}
    | {"~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "\\": r"\textbackslash{}"}
    | {"<": "$<$", ">": "$>$", "°": r"\textdegree{}"}
)


def _are_words(cells: Sequence[Sequence[str]]) -> list[bool]:
    """Returns which columns are set to the left: those with a cell that is no number."""
    _, *rows = cells
    return [not all(map(_NUMBER.fullmatch, column)) for column in zip(*rows, strict=True)]


def _latex_line(cells: Sequence[str]) -> str:
    return " & ".join(map(_latex, cells)) + r" \\"


def _latex(cell: str) -> str:
    """Escapes LaTeX's own characters, and sets a minus sign where one is meant."""
    text = "--" if cell == "-" else cell.translate(_LATEX)
    return re.sub(r"(?<![\w-])-(?=[\d.])", "$-$", text)


def show_number(value: float | None, digits: int = 2, factor: float = 1.0, sign: str = "") -> str:
    """Shows a number in the one format of all tables; a dash where there is none."""
    if value is None or math.isnan(value):
        return "-"
    return f"{factor * value:{sign}.{digits}f}"


def show_p(p: float) -> str:
    """Shows a p-value in three digits; where that would be hair-splitting, its bound."""
    return "< 0.001" if p < 0.001 else f"{p:.3f}"
