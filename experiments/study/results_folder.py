"""A folder of results that survives a kill at any moment and ends with the same bytes.

Rows enter `trials.csv` and `timings.csv`, and error curves `curves.csv.gz`, in the order of the
sweep. A trial that ends before its turn is kept in `pending.jsonl` until the rows before it exist.
Each file is only ever appended to, one whole line or curve at a time, so opening the folder again
means checking what is there, cutting torn last ones, and reading the pending rows.
"""

from __future__ import annotations

import contextlib
import dataclasses
import fcntl
import itertools
import json
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from experiments.belt.config import TrialResult, TrialTimings
from experiments.belt.curves import CURVE_HEADER
from experiments.study import records
from experiments.study.members import append_member, keep_members, read_members, write_members
from experiments.study.workers import Attempt

TRIALS, TIMINGS, CURVES, PENDING = "trials.csv", "timings.csv", "curves.csv.gz", "pending.jsonl"
ERRORS, VIDEOS = "errors", "videos"

_TRIALS_HEADER = records.header_line(TrialResult)
_TIMINGS_HEADER = records.header_line(TrialTimings)


@dataclass(frozen=True)
class Lines:
    """What is kept of a trial, as the text that goes into the files."""

    trial: str
    timings: str
    curve: str

    @property
    def trial_id(self) -> str:
        """Which trial it was."""
        return _first_cell(self.trial)

    @property
    def repeatable(self) -> tuple[str, str]:
        """What the same trial leaves again, on any machine."""
        return self.trial, self.curve


class ResultsFolder:
    """Ordered, resumable rows of one sweep."""

    def __init__(self, path: Path, trial_ids: Sequence[str]) -> None:
        self.trials_path = path / TRIALS
        self.timings_path = path / TIMINGS
        self._path = path
        self._ids = list(trial_ids)
        self._row_count = self._resume_rows()
        self._pending = self._resume_pending()
        self._flush()

    @property
    def missing(self) -> list[int]:
        """Indices of the trials that have not ended yet."""
        later = range(self._row_count, len(self._ids))
        return [index for index in later if index not in self._pending]

    def add(self, attempt: Attempt) -> None:
        """Keeps what a trial left; it is safe from a kill when this returns."""
        if attempt.crash is not None:
            errors = self._path / ERRORS
            errors.mkdir(exist_ok=True)
            traceback = attempt.crash.rstrip() + "\n"
            path = errors / f"{attempt.result.trial_id}.txt"
            records.write_whole(path, traceback.encode(errors="backslashreplace"))
        lines = Lines(
            records.row_line(attempt.result), records.row_line(attempt.timings), attempt.curve
        )
        if attempt.index > self._row_count:
            records.append_line(self._path / PENDING, _pending_line(attempt.index, lines))
        self._pending[attempt.index] = lines
        self._flush()

    def _flush(self) -> None:
        """Writes all whose turn has come; the row last, so that nothing ever lags behind it."""
        while (lines := self._pending.pop(self._row_count, None)) is not None:
            append_member(self._path / CURVES, lines.curve)
            records.append_line(self.timings_path, lines.timings)
            records.append_line(self.trials_path, lines.trial)
            self._row_count += 1
        if not self._pending:
            (self._path / PENDING).unlink(missing_ok=True)

    def _resume_rows(self) -> int:
        """Number of rows that are there; all files are brought to that length."""
        rows = _read_rows(self._path)
        for expected, row in zip(self._ids, rows, strict=False):
            if row.trial_id != expected:
                raise ValueError(
                    f"{self.trials_path} holds rows of another sweep; use another folder"
                )
        if len(rows) > len(self._ids):
            raise ValueError(f"{self.trials_path} has more rows than the sweep has trials")
        records.keep_lines(self.trials_path, _TRIALS_HEADER, len(rows))
        records.keep_lines(self.timings_path, _TIMINGS_HEADER, len(rows))
        keep_members(self._path / CURVES, CURVE_HEADER, len(rows))
        return len(rows)

    def _resume_pending(self) -> dict[int, Lines]:
        """What ended before its turn, by index."""
        pending = _read_pending(self._path, cut=True)
        if any(lines.trial_id != self._ids[index] for index, lines in pending.items()):
            raise ValueError(f"{self._path / PENDING} holds rows of another sweep")
        return {index: lines for index, lines in pending.items() if index >= self._row_count}


def read_lines(path: Path) -> dict[str, Lines]:
    """Trial id -> its lines, of all trials that have ended; nothing in the folder is changed."""
    # Rows leave the pending file for the others: read in this order none escapes.
    pending = _read_pending(path)
    return {lines.trial_id: lines for lines in [*pending.values(), *_read_rows(path)]}


def write_lines(path: Path, lines: Mapping[int, Lines]) -> None:
    """Replaces the rows of a folder by those of the trials with these indices."""
    count = next(index for index in itertools.count() if index not in lines)
    rows = [lines[index] for index in range(count)]
    write_members(path / CURVES, [CURVE_HEADER, *(row.curve for row in rows)])
    timings = [_TIMINGS_HEADER, *(row.timings for row in rows)]
    records.write_whole(path / TIMINGS, "".join(timings))
    records.write_whole(path / TRIALS, "".join([_TRIALS_HEADER, *(row.trial for row in rows)]))
    later = [_pending_line(index, lines[index]) for index in sorted(lines) if index > count]
    records.write_whole(path / PENDING, "".join(later))


def _pending_line(index: int, lines: Lines) -> str:
    return json.dumps({"index": index, **dataclasses.asdict(lines)}) + "\n"


def _read_pending(path: Path, *, cut: bool = False) -> dict[int, Lines]:
    """What ended before its turn, by index; with `cut`, a torn last entry is removed."""
    entries = [json.loads(line) for line in records.whole_lines(path / PENDING, cut=cut)]
    return {entry.pop("index"): Lines(**entry) for entry in entries}


def _read_rows(path: Path) -> list[Lines]:
    """All trials that have their row; ValueError where one lacks its timings or its curve."""
    # A sweep that still runs writes the row last: read first, it never runs ahead.
    trials = _behind(_TRIALS_HEADER, path / TRIALS, records.whole_lines(path / TRIALS))
    timings = _behind(_TIMINGS_HEADER, path / TIMINGS, records.whole_lines(path / TIMINGS))
    members = read_members(path / CURVES)
    curves = _behind(CURVE_HEADER, path / CURVES, [member.text for member in members])
    rows = [Lines(*texts) for texts in zip(trials, timings, curves, strict=False)]
    for name, count, ids in (
        (TIMINGS, len(timings), [_first_cell(row.timings) for row in rows]),
        (CURVES, len(curves), [_first_cell(row.curve) or row.trial_id for row in rows]),
    ):
        if count < len(trials) or ids != [row.trial_id for row in rows]:
            raise ValueError(f"{path / name} is not that of {TRIALS}")
    return rows


def _behind(header: str, path: Path, texts: Sequence[str]) -> Sequence[str]:
    """Texts of a file without the header."""
    if texts and texts[0] != header:
        raise ValueError(
            f"{path} has the columns of another version of beltgrasp, and cannot be continued"
        )
    return texts[1:]


def _first_cell(text: str) -> str:
    """Where a row, or the first of several, names its trial; empty for no row."""
    return text.partition(",")[0]


@contextlib.contextmanager
def exclusive(folder: Path) -> Generator[None, None, None]:
    """Keeps a second sweep out of the folder; the lock ends with the process, however it ends."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = (folder / ".lock").open("w")
    except OSError as error:
        raise OSError(f"cannot write to {folder}: {error.strerror}") from error
    with lock as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise ValueError(f"another sweep is writing to {folder}; let it end first") from None
        yield
