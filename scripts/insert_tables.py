"""Puts the tables of results/ into the documents that show them.

    python scripts/insert_tables.py [--check]

A document shows a table between `<!-- results/.../NAME.md -->` and `<!-- end -->`; where the table
does not exist yet, it says so. With --check nothing is written, and the exit code is 1 where a
document is out of date.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
NOT_YET = "*No such table yet.*\n"
BLOCK = re.compile(r"(<!-- (results/\S+\.md) -->\n).*?(<!-- end -->)", re.DOTALL)


def refreshed(text: str) -> str:
    """`text` with every table as it is in results/ now."""

    def table(match: re.Match[str]) -> str:
        path = ROOT / match[2]
        content = path.read_text(encoding="utf-8") if path.exists() else NOT_YET
        return f"{match[1]}\n{content}\n{match[3]}"

    return BLOCK.sub(table, text)


def stale() -> list[Path]:
    """The documents of which a table is not as it is in results/ now."""
    documents = (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
    texts = {path: path.read_text(encoding="utf-8") for path in documents}
    return [path for path, text in texts.items() if refreshed(text) != text]


def main() -> int:
    """Refreshes or checks README.md and docs/."""
    if "--check" in sys.argv[1:]:
        for path in (found := stale()):
            print(f"{path.relative_to(ROOT)}: a table is not that of results/", file=sys.stderr)
        return 1 if found else 0
    for path in stale():
        path.write_text(refreshed(path.read_text(encoding="utf-8")), encoding="utf-8")
        print(path.relative_to(ROOT))
    return 0


if __name__ == "__main__":
    sys.exit(main())
