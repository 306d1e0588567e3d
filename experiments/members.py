"""A gzip file that only grows: one member for each text, so that a kill tears at most the last.

Members in a row are one gzip file to `zcat`, pandas and everything else that reads gzip.
"""

from __future__ import annotations

import gzip
import os
import zlib
from dataclasses import dataclass
from pathlib import Path

from experiments.records import append_bytes

_PIECE_BYTES = 1 << 14


@dataclass(frozen=True)
class Member:
    """One text, and where in the file it ends."""

    text: str
    end: int


def append_member(path: Path, text: str) -> None:
    """Adds a text as one member, by a single write; equal texts give equal bytes."""
    append_bytes(path, gzip.compress(text.encode(), mtime=0))


def read_members(path: Path, *, cut: bool = False) -> list[Member]:
    """The whole members of a file that may not exist; with `cut`, a torn last one is removed."""
    if not path.exists():
        return []
    data = memoryview(path.read_bytes())
    members: list[Member] = []
    end = 0
    while end < len(data):
        try:
            member = _inflate(data, end)
        except (zlib.error, UnicodeDecodeError) as error:
            raise ValueError(f"{path} is damaged at byte {end}: {error}") from error
        if member is None:
            break
        members.append(member)
        end = member.end
    if cut and end < len(data):
        os.truncate(path, end)
    return members


def _inflate(data: memoryview, start: int) -> Member | None:
    """The member that begins at `start`; None for a torn one."""
    inflater = zlib.decompressobj(wbits=16 + zlib.MAX_WBITS)
    text, end = b"", start
    while not inflater.eof:
        if end == len(data):
            return None
        piece = data[end : end + _PIECE_BYTES]
        text += inflater.decompress(piece)
        end += len(piece)
    return Member(text.decode(), end - len(inflater.unused_data))
