"""Which sequences of a folder a user means: by name, by challenge, or by a list in a file."""

import contextlib
import difflib
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from experiments.video.protocols import runs_of
from experiments.video.sequences import (
    SequenceError,
    find_sequences,
    load_sequence,
    read_attributes,
)
from experiments.video.tb50 import ATTRIBUTES, TB50_ATTRIBUTES

TB50 = "TB-50"
"""The word for the fifty sequences of that list, as far as they are there."""


def select(
    sequences: Mapping[str, tuple[str, ...]], wanted: Iterable[tuple[str, str]]
) -> tuple[list[str], list[str]]:
    """The sequences asked for, in their order, and a complaint about each word that asks for none.

    Args:
        sequences: Name -> attributes of all there are.
        wanted: A word (name, attribute or TB-50) and where it stands, for the complaint.
    """
    chosen: set[str] = set()
    complaints: list[str] = []
    for word, place in wanted:
        if word == TB50:
            found = {name for name in sequences if name in TB50_ATTRIBUTES}
        elif word in ATTRIBUTES:
            found = {name for name, tags in sequences.items() if word in tags}
        else:
            found = {word} & set(sequences)
        if not found:
            complaints.append(f"{place}: {_complaint(word, sequences)}")
        chosen |= found
    return [name for name in sequences if name in chosen], complaints


def usable_sequences(
    root: Path, wanted: Sequence[tuple[str, str]], protocols: Sequence[str]
) -> tuple[list[str], list[str]]:
    """The sequences of a folder that can be run, and a complaint about each other one.

    Args:
        root: Folder of the sequences.
        wanted: Words and where they stand, as `select` takes them; all sequences where empty.
        protocols: Those by which the sequences are to be run.
    """
    found = find_sequences(root)
    names, complaints = select(_attributes(found), wanted) if wanted else ([*found], [])
    usable: list[str] = []
    for name in names:
        try:
            sequence = load_sequence(name, found[name])
            for protocol in protocols:
                runs_of(protocol, sequence)
        except SequenceError as error:
            complaints.append(f"{name}: {error}")
            continue
        usable.append(name)
        if sequence.spare_image_count:
            line = sequence.line(len(sequence) - 1)
            spare = f"{sequence.spare_image_count} images have no box and do not count"
            print(f"note: {name}: {line} is the last: {spare}", file=sys.stderr)
    return usable, complaints


def _attributes(found: Mapping[str, Path]) -> dict[str, tuple[str, ...]]:
    """Challenges of each sequence; none for one whose list is faulty, which loading it reports."""
    tags: dict[str, tuple[str, ...]] = dict.fromkeys(found, ())
    for name, path in found.items():
        with contextlib.suppress(SequenceError):
            tags[name] = read_attributes(name, path.parent)
    return tags


def read_list(path: Path) -> list[tuple[str, str]]:
    """The first word of each line and its place; empty lines and comments (#) are passed over.

    The benchmark's own `tb_50.txt` can be given as it is.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except UnicodeDecodeError:
        raise ValueError(f"{path}: not a text file") from None
    words = [line.partition("#")[0].split() for line in lines]
    found = [(first[0], f"{path}, line {n}") for n, first in enumerate(words, 1) if first]
    if not found:
        raise ValueError(f"{path}: names no sequence")
    return found


def _complaint(word: str, sequences: Mapping[str, tuple[str, ...]]) -> str:
    if word in ATTRIBUTES or word == TB50:
        return f"no sequence is of {word}"
    names = [*sequences, *ATTRIBUTES, TB50]
    near = difflib.get_close_matches(word, names, n=1)
    suggestion = f"; did you mean {near[0]!r}?" if near else ""
    known = f"sequences: {', '.join(sequences)}; attributes: {', '.join([*ATTRIBUTES, TB50])}"
    return f"no sequence or attribute {word!r}{suggestion}; {known}"
