"""A folder of results that survives a kill at any moment and ends with the same bytes.

Rows enter `trials.csv` and `timings.csv`, and error curves `curves.csv.gz`, in the order of the
sweep. A trial that ends before its turn is kept in `pending.jsonl` until the rows before it exist.
Each file is only ever appended to, one whole line or curve at a time, so opening the folder again
means cutting torn last ones, checking what is there, and reading the pending rows.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
from collections.abc import Generator, Sequence
from pathlib import Path
from typing import NamedTuple

from experiments import records
from experiments.config import TrialResult, TrialTimings
from experiments.curves import CURVE_HEADER
from experiments.members import append_member, read_members
from experiments.workers import Attempt


class _Left(NamedTuple):
    """What a trial left, as the text that goes into the files."""

    trial: str
    timings: str
    curve: str


class ResultsFolder:
    """Ordered, resumable rows of one sweep."""

    def __init__(self, path: Path, trial_ids: Sequence[str]) -> None:
        self.trials_path = path / "trials.csv"
        self.timings_path = path / "timings.csv"
        self.curves_path = path / "curves.csv.gz"
        self._pending_path = path / "pending.jsonl"
        self._errors_path = path / "errors"
        self._ids = list(trial_ids)
        self._row_count = self._resume_rows()
        self._resume_curves()
        self._pending = self._resume_pending()
        self._flush()

    @property
    def missing(self) -> list[int]:
        """Indices of the trials that have not ended yet."""
        later = range(self._row_count, len(self._ids))
        return [index for index in later if index not in self._pending]

    @property
    def is_complete(self) -> bool:
        """Whether every trial has its row."""
        return self._row_count == len(self._ids)

    def add(self, attempt: Attempt) -> None:
        """Keeps what a trial left; it is safe from a kill when this returns."""
        if attempt.crash is not None:
            self._errors_path.mkdir(exist_ok=True)
            path = self._errors_path / f"{attempt.result.trial_id}.txt"
            path.write_text(attempt.crash.rstrip() + "\n")
        left = _Left(
            records.row_line(attempt.result), records.row_line(attempt.timings), attempt.curve
        )
        if attempt.index > self._row_count:
            entry = json.dumps({"index": attempt.index, **left._asdict()})
            records.append_line(self._pending_path, entry + "\n")
        self._pending[attempt.index] = left
        self._flush()

    def _flush(self) -> None:
        """Writes all whose turn has come; the row last, so that nothing ever lags behind it."""
        while (left := self._pending.pop(self._row_count, None)) is not None:
            append_member(self.curves_path, left.curve)
            records.append_line(self.timings_path, left.timings)
            records.append_line(self.trials_path, left.trial)
            self._row_count += 1
        if not self._pending:
            self._pending_path.unlink(missing_ok=True)

    def _resume_rows(self) -> int:
        """Number of rows that are there; both files are brought to that length."""
        trials = self._open_csv(self.trials_path, records.header_line(TrialResult))
        timings = self._open_csv(self.timings_path, records.header_line(TrialTimings))
        if len(timings) < len(trials):
            raise ValueError(f"{self.timings_path} has fewer rows than {self.trials_path.name}")
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

    def _resume_curves(self) -> None:
        """Brings the curves to the length of the rows; a new file gets its header."""
        members = read_members(self.curves_path, cut=True)
        if not members:
            append_member(self.curves_path, CURVE_HEADER)
            members = read_members(self.curves_path)
        if members[0].text != CURVE_HEADER or len(members) <= self._row_count:
            raise ValueError(f"{self.curves_path} is not that of {self.trials_path.name}")
        for expected, member in zip(self._ids[: self._row_count], members[1:], strict=False):
            if member.text and _trial_id(member.text) != expected:
                raise ValueError(f"{self.curves_path} holds curves of another sweep")
        os.truncate(self.curves_path, members[self._row_count].end)

    @staticmethod
    def _open_csv(path: Path, header: str) -> list[str]:
        """Rows of a file as lines; a new file gets its header."""
        lines = records.whole_lines(path, cut=True)
        if not lines:
            records.append_line(path, header)
        elif lines[0] != header:
            raise ValueError(
                f"{path} has the columns of another version of beltgrasp; use another folder"
            )
        return lines[1:]

    def _resume_pending(self) -> dict[int, _Left]:
        """What ended before its turn, by index."""
        pending: dict[int, _Left] = {}
        for line in records.whole_lines(self._pending_path, cut=True):
            entry = json.loads(line)
            index = entry.pop("index")
            left = _Left(**entry)
            if _trial_id(left.trial) != self._ids[index]:
                raise ValueError(f"{self._pending_path} holds rows of another sweep")
            if index >= self._row_count:
                pending[index] = left
        return pending


def _trial_id(line: str) -> str:
    """First cell of a row, or of the first of several."""
    return line.partition(",")[0]


@contextlib.contextmanager
def exclusive(folder: Path) -> Generator[None, None, None]:
    """Keeps a second sweep out of the folder; the lock ends with the process, however it ends."""
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / ".lock").open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise ValueError(f"another sweep is writing to {folder}; let it end first") from None
        yield
