"""Runs the worlds of a rendered experiment in worker processes, and keeps their rows."""

from __future__ import annotations

import contextlib
import sys
import traceback
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from tqdm import tqdm

from experiments.apple.row_file import RowFile
from experiments.study.processes import Lost, Workers
from experiments.study.progress import progress_bar
from experiments.study.results_folder import exclusive
from experiments.study.study_folder import claim

Job = TypeVar("Job")
Row = TypeVar("Row")


@dataclass(frozen=True)
class Outcome(Generic[Job, Row]):
    """What became of one world."""

    job: Job
    rows: tuple[Row, ...]
    crash: str | None = None
    """Traceback of a world that failed."""


@dataclass(frozen=True)
class Attempt(Generic[Job, Row]):
    """Works on a world in a worker; an exception becomes an outcome without rows."""

    work: Callable[[Job], list[Row]]

    def __call__(self, job: Job) -> Outcome[Job, Row]:
        """The outcome of one world."""
        try:
            return Outcome(job, tuple(self.work(job)))
        except Exception:
            return Outcome(job, (), traceback.format_exc())


@dataclass(frozen=True)
class Study(Generic[Job, Row]):
    """A rendered experiment."""

    name: str
    settings: dict[str, Any]
    """What else determines the rows, as JSON holds it."""
    work: Callable[[Job], list[Row]]
    """The rows of one world; picklable."""
    key: Callable[[Job], tuple[object, ...]]
    """The key of a world's rows in the file."""


def run_study(
    study: Study[Job, Row],
    jobs: Sequence[Job],
    rows: RowFile[Row],
    order: Callable[[tuple[object, ...]], Any],
    workers: Workers,
) -> int:
    """Runs the worlds that the file lacks; returns how many failed.

    Args:
        study: The experiment.
        jobs: Its worlds; those of earlier calls with other worlds stay in the file.
        rows: Where the rows go.
        order: Sorts the keys of all worlds in the file.
        workers: Who works on them; the file does not depend on it.
    """
    folder: Path = rows.path.parent
    with exclusive(folder):
        claim(folder, "apple", study.name, workers.count, study.settings)
        done = rows.resume()
        missing = [job for job in jobs if study.key(job) not in done]
        failures = _run(study, missing, rows, workers, len(jobs))
        if rows.path.exists():
            rows.sort(order)
    return failures


def _run(
    study: Study[Job, Row], missing: Sequence[Job], rows: RowFile[Row], workers: Workers, total: int
) -> int:
    failures = 0
    answers = workers.run_all(Attempt(study.work), missing)
    with (
        contextlib.closing(answers),
        progress_bar(study.name, "world", total, total - len(missing)) as bar,
    ):
        for answer in _outcomes(answers):
            if answer.crash is None:
                rows.append(answer.rows)
            else:
                failures += 1
                reason = answer.crash.rstrip().splitlines()[-1]
                tqdm.write(f"beltgrasp: error: {answer.job}: {reason}", file=sys.stderr)
            bar.update()
    return failures


def _outcomes(
    answers: Iterable[Outcome[Job, Row] | Lost[Job]],
) -> Iterable[Outcome[Job, Row]]:
    for answer in answers:
        yield Outcome(answer.task, (), answer.remark) if isinstance(answer, Lost) else answer
