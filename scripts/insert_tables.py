"""Puts the tables of results/ into the documents that show them.

    python scripts/insert_tables.py [--check]

A document shows a table between `<!-- results/.../NAME.md -->` and `<!-- end -->`; where the table
does not exist yet, it says so. Of a long table it shows the rows that carry its argument,
`<!-- results/.../NAME.md where tracker = igpf, pf; condition = normal -->`, and links the rest.
With --check nothing is written, and the exit code is 1 where a document is out of date.
"""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
NOT_YET = "*No such table yet.*\n"
BLOCK = re.compile(
    r"(?P<start><!-- (?P<path>results/\S+\.md)(?: where (?P<where>.+?))? -->\n)"
    r".*?(?P<end><!-- end -->)",
    re.DOTALL,
)


def refreshed(text: str, folder: Path = ROOT) -> str:
    """`text`, of a document in `folder`, with every table as it is in results/ now."""

    def table(match: re.Match[str]) -> str:
        path = ROOT / match["path"]
        content = path.read_text(encoding="utf-8") if path.exists() else NOT_YET
        if match["where"] and path.exists():
            rows = selected(content, match["where"])
            link = f"[All {len(_rows(content))} rows]({os.path.relpath(path, folder)})"
            content = f"{rows}\n{link}\n"
        return f"{match['start']}\n{content}\n{match['end']}"

    return BLOCK.sub(table, text)


def selected(table: str, where: str) -> str:
    """The header of a Markdown table and the rows that fit `COLUMN = VALUE, ...; COLUMN = ...`."""
    head, rule, *_ = table.splitlines(keepends=True)
    columns = _cells(head)
    rows = _rows(table)
    for clause in where.split(";"):
        column, _, values = (part.strip() for part in clause.partition("="))
        if column not in columns:
            raise ValueError(f"column must be one of {', '.join(columns)}; got {column!r}")
        wanted = [value.strip() for value in values.split(",")]
        place = columns.index(column)
        if missing := set(wanted) - {_cells(row)[place] for row in rows}:
            raise ValueError(f"no row has {column} = {', '.join(sorted(missing))}")
        rows = [row for row in rows if _cells(row)[place] in wanted]
    return "".join([head, rule, *rows])


def _cells(row: str) -> list[str]:
    return [cell.strip() for cell in row.strip().strip("|").split(" | ")]


def _rows(table: str) -> list[str]:
    return [line for line in table.splitlines(keepends=True)[2:] if line.strip()]


def stale() -> list[Path]:
    """The documents of which a table is not as it is in results/ now."""
    documents = (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
    texts = {path: path.read_text(encoding="utf-8") for path in documents}
    return [path for path, text in texts.items() if refreshed(text, path.parent) != text]


def main() -> int:
    """Refreshes or checks README.md and docs/."""
    if "--check" in sys.argv[1:]:
        for path in (found := stale()):
            print(f"{path.relative_to(ROOT)}: a table is not that of results/", file=sys.stderr)
        return 1 if found else 0
    for path in stale():
        text = path.read_text(encoding="utf-8")
        path.write_text(refreshed(text, path.parent), encoding="utf-8")
        print(path.relative_to(ROOT))
    return 0


if __name__ == "__main__":
    sys.exit(main())
