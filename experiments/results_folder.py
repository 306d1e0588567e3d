"""A folder of results that survives a kill at any moment and ends with the same bytes.

Rows enter `trials.csv` and `timings.csv` in the order of the sweep. A trial that ends before its
turn is kept in `pending.jsonl` until the rows before it exist. Each file is only ever appended to,
one whole line at a time, so opening the folder again means cutting torn last lines, checking what
is there, and reading the pending rows.
"""

from __future__ import annotations

import contextlib
import csv
import fcntl
import itertools
import json
import os
from collections.abc import Generator, Mapping, Sequence
from pathlib import Path
from typing import TypeAlias

from experiments import records
from experiments.config import TrialResult, TrialTimings
from experiments.workers import Attempt

TRIALS, TIMINGS, PENDING = "trials.csv", "timings.csv", "pending.jsonl"
ERRORS, VIDEOS = "errors", "videos"

Lines: TypeAlias = tuple[str, str]
"""What is kept of a trial: its line of `trials.csv` and that of `timings.csv`."""


class ResultsFolder:
    """Ordered, resumable rows of one sweep."""

    def __init__(self, path: Path, trial_ids: Sequence[str]) -> None:
        self.trials_path = path / TRIALS
        self.timings_path = path / TIMINGS
        self._pending_path = path / PENDING
        self._errors_path = path / ERRORS
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
            self._errors_path.mkdir(exist_ok=True)
            path = self._errors_path / f"{attempt.result.trial_id}.txt"
            traceback = attempt.crash.rstrip() + "\n"
            records.write_whole(path, traceback.encode(errors="backslashreplace"))
        lines = (records.row_line(attempt.result), records.row_line(attempt.timings))
        if attempt.index > self._row_count:
            records.append_line(self._pending_path, _pending_line(attempt.index, lines))
        self._pending[attempt.index] = lines
        self._flush()

    def _flush(self) -> None:
        """Writes every row whose turn has come; timings first, so that they never lag behind."""
        while (lines := self._pending.pop(self._row_count, None)) is not None:
            records.append_line(self.timings_path, lines[1])
            records.append_line(self.trials_path, lines[0])
            self._row_count += 1
        if not self._pending:
            self._pending_path.unlink(missing_ok=True)

    def _resume_rows(self) -> int:
        """Number of rows that are there; both files are brought to that length."""
        for path, row_type in ((self.trials_path, TrialResult), (self.timings_path, TrialTimings)):
            if not records.whole_lines(path, cut=True):
                records.append_line(path, records.header_line(row_type))
        trials = _rows(self.trials_path, TrialResult)
        timings = _rows(self.timings_path, TrialTimings)
        _require_timings(self.trials_path.parent, trials, timings)
        kept = len(trials)
        for path, lines in ((self.trials_path, trials), (self.timings_path, timings)):
            for expected, line in zip(self._ids[:kept], lines, strict=False):
                if _trial_id(line) != expected:
                    raise ValueError(f"{path} holds rows of another sweep; use another folder")
        if kept > len(self._ids):
            raise ValueError(f"{self.trials_path} has more rows than the sweep has trials")
        surplus = sum(len(line.encode()) for line in timings[kept:])
        if surplus:
            os.truncate(self.timings_path, self.timings_path.stat().st_size - surplus)
        return kept

    def _resume_pending(self) -> dict[int, Lines]:
        """Rows that ended before their turn, by index."""
        pending: dict[int, Lines] = {}
        for line in records.whole_lines(self._pending_path, cut=True):
            entry = json.loads(line)
            index, lines = entry["index"], (entry["trial"], entry["timings"])
            if _trial_id(lines[0]) != self._ids[index]:
                raise ValueError(f"{self._pending_path} holds rows of another sweep")
            if index >= self._row_count:
                pending[index] = lines
        return pending


def read_lines(path: Path) -> dict[str, Lines]:
    """Trial id -> its lines, of all trials that have ended; nothing in the folder is changed."""
    # Rows leave the pending file for the others: read in this order none escapes.
    pending = [json.loads(line) for line in records.whole_lines(path / PENDING)]
    trials, timings = _rows(path / TRIALS, TrialResult), _rows(path / TIMINGS, TrialTimings)
    _require_timings(path, trials, timings)
    lines = [(entry["trial"], entry["timings"]) for entry in pending]
    lines += zip(trials, timings, strict=False)
    return {_trial_id(trial): (trial, timing) for trial, timing in lines}


def write_lines(path: Path, lines: Mapping[int, Lines]) -> None:
    """Replaces the rows of a folder by those of the trials with these indices."""
    count = next(index for index in itertools.count() if index not in lines)
    headers = records.header_line(TrialTimings), records.header_line(TrialResult)
    for name, header, part in zip((TIMINGS, TRIALS), headers, (1, 0), strict=True):
        rows = [lines[index][part] for index in range(count)]
        records.write_whole(path / name, "".join([header, *rows]))
    later = [_pending_line(index, lines[index]) for index in sorted(lines) if index > count]
    records.write_whole(path / PENDING, "".join(later))


def _pending_line(index: int, lines: Lines) -> str:
    return json.dumps({"index": index, "trial": lines[0], "timings": lines[1]}) + "\n"


def _rows(path: Path, row_type: type[TrialResult] | type[TrialTimings]) -> list[str]:
    """Rows of a file as lines, without the header."""
    lines = records.whole_lines(path)
    if lines and lines[0] != records.header_line(row_type):
        raise ValueError(
            f"{path} has the columns of another version of beltgrasp, and cannot be continued"
        )
    return lines[1:]


def _require_timings(path: Path, trials: Sequence[str], timings: Sequence[str]) -> None:
    if len(timings) < len(trials):
        raise ValueError(f"{path / TIMINGS} has fewer rows than {TRIALS}")


def _trial_id(line: str) -> str:
    """First cell of a row."""
    return next(csv.reader([line]))[0]


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
