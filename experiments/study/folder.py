"""A results folder: rows, timings and curves of a study, which survive a kill at any moment.

While jobs end, each is one line of `journal.jsonl`, appended by a single write. When a run ends or
is stopped, and when the folder is opened again, the journal goes into `rows.csv`, `timings.csv` and
the compressed files of curves, in the order of the jobs and each replaced in one step. So the bytes
do not depend on the number of workers, on kills, or on what was run first.
"""

import csv
import gzip
import json
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Generic

from experiments.report.table import csv_line
from experiments.study import rows
from experiments.study.files import append_line, whole_lines, write_whole
from experiments.study.manifest import OTHER_FOLDER
from experiments.study.study import Job, Key, Result, Results, Row, Study

ROWS, TIMINGS, JOURNAL = "rows.csv", "timings.csv", "journal.jsonl"
ERRORS, VIDEOS = "errors", "videos"


@dataclass(frozen=True)
class Entry:
    """What is kept of a job, as the text that goes into the files."""

    key: Key
    rows: str
    """Lines of `rows.csv`."""
    timings: str = ""
    """Line of `timings.csv`."""
    curves: Mapping[str, str] = field(default_factory=dict[str, str])
    """Name of a file of curves -> lines."""
    is_error: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "key", tuple(self.key))

    @property
    def repeatable(self) -> tuple[str, Mapping[str, str]]:
        """What the same job leaves again, on any machine of its kind."""
        return self.rows, self.curves


class ResultsFolder(Generic[Job, Row]):
    """The results of a study's jobs, which are kept as they end."""

    def __init__(self, path: Path, study: Study[Job, Row], jobs: Sequence[Job]) -> None:
        """Opens the folder and puts in order what an earlier run left.

        Raises ValueError where it holds rows that are none of the jobs'.
        """
        self.rows_path = path / ROWS
        self._path, self._study = path, study
        self._places = {study.key_of(job): place for place, job in enumerate(jobs)}
        self._entries = read_entries(path, study)
        strangers = self._entries.keys() - self._places.keys()
        if strangers:
            raise ValueError(
                f"{path} holds a row of another selection, {' '.join(min(strangers))}; "
                f"{OTHER_FOLDER}"
            )
        self.close()

    def missing(self, jobs: Iterable[Job], *, retry: bool = True) -> list[Job]:
        """Of these jobs, those without a row, and with `retry` those that crashed."""
        return [job for job in jobs if self._is_missing(self._study.key_of(job), retry)]

    def _is_missing(self, key: Key, retry: bool) -> bool:
        return key not in self._entries or (retry and self._entries[key].is_error)

    def add(self, job: Job, result: Result[Row]) -> None:
        """Keeps what a job left; it is safe from a kill when this returns."""
        key = self._study.key_of(job)
        if result.error is not None:
            self._keep_traceback(key, result.error)
        for name, content in result.files.items():
            path = self._path / name
            path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(path, content)
        entry = Entry(
            key=key,
            rows="".join(map(rows.row_line, result.rows)),
            timings=_timings_line(self._study, key, result),
            curves=dict(result.curves),
            is_error=result.error is not None,
        )
        append_line(self._path / JOURNAL, json.dumps(asdict(entry)) + "\n")
        self._entries[key] = entry

    def close(self) -> None:
        """Writes the files anew where they lack what is in the journal, or are in another order."""
        entries = sorted(self._entries.values(), key=lambda entry: self._places[entry.key])
        is_in_order = self.rows_path.exists() and entries == [*self._entries.values()]
        if not is_in_order or (self._path / JOURNAL).exists():
            write_entries(self._path, self._study, entries)

    def rows_of(self, job: Job) -> list[Row]:
        """The typed rows of a job that has ended."""
        text = self._entries[self._study.key_of(job)].rows
        header = rows.header_line(self._study.row)
        return rows.parse_rows(self.rows_path, [header, *text.splitlines(True)], self._study.row)

    @property
    def mean_wall_s(self) -> float | None:
        """What a job of the folder has taken on average [s]; None before any has ended."""
        place = timings_header(self._study).rstrip("\n").split(",").index("wall_s")
        lines = [entry.timings for entry in self._entries.values() if entry.timings]
        times = [float(line.rstrip("\n").split(",")[place]) for line in lines]
        return sum(times) / len(times) if times else None

    def counts(self, jobs: Iterable[Job]) -> tuple[int, int]:
        """How many of these jobs have ended in a failure, and how many have crashed."""
        failures = crashes = 0
        for job in jobs:
            entry = self._entries.get(self._study.key_of(job))
            if entry is not None and entry.is_error:
                crashes += 1
            elif entry is not None:
                failures += self._study.is_failure(self.rows_of(job))
        return failures, crashes

    def _keep_traceback(self, key: Key, error: str) -> None:
        """Adds a traceback to those of earlier tries."""
        path = error_path(self._path, key)
        path.parent.mkdir(parents=True, exist_ok=True)
        before = path.read_text(encoding="utf-8") + "\n" if path.exists() else ""
        write_whole(path, (before + error.rstrip() + "\n").encode(errors="backslashreplace"))


def error_path(folder: Path, key: Key) -> Path:
    """Where the tracebacks of a job are kept."""
    name = "_".join(key).replace("/", ".").replace(":", ".")
    return folder / ERRORS / f"{name}.txt"


def read_results(folder: Path, study: Study[Any, Row]) -> Results[Row]:
    """What a folder holds, also of a run that still goes on; ValueError where that is nothing."""
    entries = read_entries(folder, study).values()
    if not entries:
        raise ValueError(f"{folder} holds no finished {study.unit} yet")
    lines = [line for entry in entries for line in entry.rows.splitlines(True)]
    timings: list[Any] = []
    if study.timings is not None:
        timed = [entry.timings for entry in entries if entry.timings]
        header = rows.header_line(study.timings)
        timings = rows.parse_rows(folder / TIMINGS, [header, *timed], study.timings)
    header = rows.header_line(study.row)
    return Results(
        path=folder,
        rows=rows.parse_rows(folder / ROWS, [header, *lines], study.row),
        timings=timings,
        curves={
            name: {entry.key: text for entry in entries if (text := entry.curves.get(name, ""))}
            for name in study.curves
        },
    )


def read_entries(folder: Path, study: Study[Any, Any]) -> dict[Key, Entry]:
    """What is kept of each job, by key; nothing in the folder is changed.

    A journal line is newer than the files. A run that goes on removes the journal only after it
    has replaced the files: read in this order nothing escapes.
    """
    journal: list[dict[str, Any]] = [json.loads(line) for line in whole_lines(folder / JOURNAL)]
    path = folder / ROWS
    kept = _by_key(path, whole_lines(path), study, rows.header_line(study.row))
    for path in (folder / TIMINGS, *(curves_path(folder, name) for name in study.curves)):
        if kept and not (path.exists() and path.stat().st_size):
            raise ValueError(f"{path} is missing beside {ROWS}; put it back, or {OTHER_FOLDER}")
    path = folder / TIMINGS
    timings = _by_key(path, whole_lines(path), study, timings_header(study))
    curves = {
        name: _by_key(path, _unzipped(path), study, header)
        for name, header in study.curves.items()
        if (path := curves_path(folder, name)).exists()
    }
    entries = {
        key: Entry(
            key,
            lines,
            timings.get(key, ""),
            {name: texts[key] for name, texts in curves.items() if key in texts},
            is_error=_outcome(lines, study) == "error",
        )
        for key, lines in kept.items()
    }
    newer = [Entry(**fields) for fields in journal]
    return entries | {entry.key: entry for entry in newer}


def write_entries(folder: Path, study: Study[Any, Any], entries: Sequence[Entry]) -> None:
    """Replaces the files of a folder by these entries, and removes the journal."""
    for name, header in study.curves.items():
        text = header + "".join(entry.curves.get(name, "") for entry in entries)
        write_whole(curves_path(folder, name), gzip.compress(text.encode(), mtime=0))
    timings = timings_header(study) + "".join(entry.timings for entry in entries)
    write_whole(folder / TIMINGS, timings)
    header = rows.header_line(study.row)
    write_whole(folder / ROWS, header + "".join(entry.rows for entry in entries))
    (folder / JOURNAL).unlink(missing_ok=True)


def curves_path(folder: Path, name: str) -> Path:
    """The compressed file of the curves of that name."""
    return folder / f"{name}.csv.gz"


def timings_header(study: Study[Any, Any]) -> str:
    """Header of `timings.csv`."""
    if study.timings is not None:
        return rows.header_line(study.timings)
    return csv_line([*study.key, "wall_s"])


def _timings_line(study: Study[Any, Any], key: Key, result: Result[Any]) -> str:
    if study.timings is None:
        return csv_line([*key, result.wall_s])
    return "" if result.timings is None else rows.row_line(result.timings)


def _by_key(
    path: Path, lines: Sequence[str], study: Study[Any, Any], header: str
) -> Mapping[Key, str]:
    """The lines of each job, in the order of the file; ValueError for other columns."""
    if not lines:
        return {}
    if lines[0] != header:
        raise ValueError(f"{path} has the columns of another version of beltgrasp; {OTHER_FOLDER}")
    names = header.rstrip("\n").split(",")
    places = [names.index(name) for name in study.key]
    found: dict[Key, list[str]] = {}
    for line, cells in zip(lines[1:], csv.reader(lines[1:]), strict=True):
        found.setdefault(tuple(cells[place] for place in places), []).append(line)
    return {key: "".join(group) for key, group in found.items()}


def _outcome(lines: str, study: Study[Any, Any]) -> str:
    """The cell `outcome` of the first line."""
    place = rows.columns(study.row).index("outcome")
    return next(csv.reader([lines.partition("\n")[0]]))[place]


def _unzipped(path: Path) -> list[str]:
    """The lines of a gzip file."""
    try:
        return gzip.decompress(path.read_bytes()).decode().splitlines(keepends=True)
    except (OSError, EOFError, zlib.error, UnicodeDecodeError) as error:
        raise ValueError(f"{path} is damaged: {error}") from error
