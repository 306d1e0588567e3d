"""A gzip file that only grows: one member for each text, so that a kill tears at most the last.

Members in a row are one gzip file to `zcat`, pandas and everything else that reads gzip.
"""

from __future__ import annotations

import gzip
import zlib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from experiments.study import records

_PIECE_BYTES = 1 << 14


@dataclass(frozen=True)
class Member:
    """One text, and where in the file it ends."""

    text: str
    end: int


def append_member(path: Path, text: str) -> None:
    """Adds a text as one member, by a single write; equal texts give equal bytes."""
    records.append_bytes(path, _deflate(text))


def write_members(path: Path, texts: Iterable[str]) -> None:
    """Replaces the file by these texts in one step; the bytes are those of appending them."""
    records.write_whole(path, b"".join(map(_deflate, texts)))


def keep_members(path: Path, header: str, count: int) -> None:
    """Leaves so many members behind the header, which a new file gets."""
    members = read_members(path)[: 1 + count]
    if members:
        records.cut_off(path, members[-1].end)
    else:
        write_members(path, [header])


def read_members(path: Path) -> list[Member]:
    """The whole members of a file that may not exist; a torn last one is not among them."""
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
    return members


def _deflate(text: str) -> bytes:
    return gzip.compress(text.encode(), mtime=0)


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
