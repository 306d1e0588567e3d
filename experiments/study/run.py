"""Runs the jobs that a results folder lacks; the same command again resumes.

Rows have the same bytes whoever runs the jobs: one worker or many, a cluster, shards, and after
any interruption. A job that crashes leaves a row with `outcome` error and its traceback, and is
tried again by the next run.
"""

import contextlib
import sys
import time
import traceback
from collections.abc import Generator, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Generic, Literal, TypeAlias

from tqdm import tqdm

from experiments.report.table import format_cell
from experiments.study import rows
from experiments.study.files import exclusive
from experiments.study.films import VideoChoice, make_films
from experiments.study.folder import ROWS, ResultsFolder
from experiments.study.manifest import Request, claim
from experiments.study.processes import Lost, Workers
from experiments.study.progress import progress_bar
from experiments.study.provenance import provenance
from experiments.study.shard import Shard
from experiments.study.study import Job, Result, Row, Selection, Study, load

RetryChoice: TypeAlias = Literal["crashed", "none"]


class Interrupted(Exception):
    """Ctrl-C ended the run; what is finished is kept."""


@dataclass(frozen=True)
class Options:
    """How to run a study: everything on which the rows do not depend."""

    shard: Shard | None = None
    retry: RetryChoice = "crashed"
    video: VideoChoice = "none"


@dataclass(frozen=True)
class Summary:
    """What a run has left behind."""

    rows_path: Path
    job_count: int
    """Jobs that were asked for."""
    failure_count: int
    """Those of them that ended in a failure, as the study defines it."""
    error_count: int
    """Those that crashed."""
    video_count: int = 0
    """Videos that were asked for and are there."""
    lost_video_count: int = 0
    """Videos that could not be made."""


def run(
    study: Study[Job, Row],
    selection: Selection,
    out: Path,
    workers: Workers,
    options: Options | None = None,
) -> Summary:
    """Runs the jobs of a selection that `out` lacks, and keeps what they leave as they end.

    Args:
        study: What to run.
        selection: Which jobs of it; those of earlier runs stay in the folder.
        out: Results folder: new, empty, or one of the same study with the same settings.
        workers: Who runs the jobs; the rows do not depend on it.
        options: Shard, retries and videos.

    Raises ValueError, before anything is written, for names and videos that there are not.
    """
    options = options or Options()
    if options.video != "none" and not study.film:
        raise ValueError(f"{study.name} has no videos; --video must be none")
    request = Request[Job].of(study, selection, options.shard)
    jobs = request.jobs
    with exclusive(out):
        manifest = claim(out, study, request, workers.count)
        folder = ResultsFolder(out, study, manifest.jobs(study))
        missing = folder.missing(jobs, retry=options.retry == "crashed")
        _announce(study, jobs, missing, workers.count, folder.mean_wall_s)
        with _saying_what_is_kept(folder, jobs, out):
            _run_missing(study, folder, jobs, missing, workers)
            films = make_films(study, folder, jobs, options.video, workers)
        manifest.end_session(out)
    return Summary(out / ROWS, len(jobs), *folder.counts(jobs), *films)


def keep(
    study: Study[Job, Row], selection: Selection, out: Path, job: Job, result: Result[Row]
) -> None:
    """Keeps a result in a folder; the selection asks for its job alone.

    A crash does not take the place of an earlier good result.
    """
    request = Request[Job].of(study, selection, None)
    with exclusive(out):
        manifest = claim(out, study, request, 1)
        folder = ResultsFolder(out, study, manifest.jobs(study))
        if result.error is None or folder.missing([job]):
            folder.add(job, result)
        folder.close()
        manifest.end_session(out)


@contextlib.contextmanager
def _saying_what_is_kept(
    folder: ResultsFolder[Job, Row], jobs: Sequence[Job], out: Path
) -> Generator[None, None, None]:
    """Puts the files in order at the end, also after Ctrl-C, a full disk or a lost cluster."""
    try:
        yield
    except (KeyboardInterrupt, OSError) as error:
        kept = len(jobs) - len(folder.missing(jobs, retry=False))
        text = f"{kept} of {len(jobs)} are kept in {out}"
        if isinstance(error, OSError):
            raise OSError(f"{error}; {text}, and the same command resumes") from error
        folder.close()
        raise Interrupted(f"stopped; {text}") from None
    folder.close()


@dataclass(frozen=True)
class Work(Generic[Job, Row]):
    """What every worker is given: runs jobs; an exception becomes a result with an error."""

    study: Study[Job, Row]

    def __call__(self, jobs: tuple[Job, ...]) -> list[tuple[Job, Result[Row]]]:
        """Each job with its result."""
        started_s = time.perf_counter()
        try:
            results: list[Result[Row]] = list(load(self.study.work)(jobs))
            for job, result in zip(jobs, results, strict=True):
                _check(self.study, job, result)
        except Exception as error:
            wall_s = time.perf_counter() - started_s
            detail = f"{type(error).__name__}: {error}"
            return crashed(self.study, jobs, wall_s, detail, traceback.format_exc())
        wall_s = (time.perf_counter() - started_s) / len(jobs)
        return [(job, replace(r, wall_s=wall_s)) for job, r in zip(jobs, results, strict=True)]


def _check(study: Study[Job, Row], job: Job, result: Result[Row]) -> None:
    """Raises where a result is not that of its job, or cannot be written."""
    key = study.key_of(job)
    for row in result.rows:
        found = tuple(format_cell(getattr(row, name)) for name in study.key)
        if found != key:
            raise RuntimeError(f"{study.unit} {' '.join(key)} returned a row of {' '.join(found)}")
        rows.row_line(row)


def crashed(
    study: Study[Job, Row], jobs: Sequence[Job], wall_s: float, detail: str, error: str
) -> list[tuple[Job, Result[Row]]]:
    """The results of jobs that ended in an error: `detail` in a line, `error` in full."""
    return [(job, _crashed_one(study, job, wall_s, detail, error)) for job in jobs]


def _crashed_one(
    study: Study[Job, Row], job: Job, wall_s: float, detail: str, error: str
) -> Result[Row]:
    known = {**study.identity(job), **provenance(), "wall_s": wall_s}
    row = rows.error_row(study.row, known, detail)
    timings = None if study.timings is None else rows.error_row(study.timings, known, detail)
    return Result((row,), timings, error=error, wall_s=wall_s)


def _run_missing(
    study: Study[Job, Row],
    folder: ResultsFolder[Job, Row],
    jobs: Sequence[Job],
    missing: Sequence[Job],
    workers: Workers,
) -> None:
    answers = workers.run_all(Work(study), batches(study, missing))
    bar = progress_bar(study.name, study.unit, len(jobs), len(jobs) - len(missing))
    failures = errors = 0
    with contextlib.closing(answers), bar:
        for answer in answers:
            for job, result in _results(study, answer):
                folder.add(job, result)
                if result.error is None:
                    failures += study.is_failure(result.rows)
                else:
                    errors += 1
                    crashed_row: Any = result.rows[0]
                    line = f"beltgrasp: error: {study.title(job)}: {crashed_row.detail}"
                    tqdm.write(" ".join(line.split()), file=sys.stderr)
                bar.set_postfix_str(_running_counts(failures, errors), refresh=False)
                bar.update()


def _results(
    study: Study[Job, Row],
    answer: list[tuple[Job, Result[Row]]] | Lost[tuple[Job, ...]],
) -> Iterable[tuple[Job, Result[Row]]]:
    if isinstance(answer, Lost):
        return crashed(study, answer.task, answer.wall_s, answer.remark, answer.remark)
    return answer


def _running_counts(failures: int, errors: int) -> str:
    """Failures and crashes so far."""
    text = f"failures {failures}" if failures else ""
    return text + (f", errors {errors}" if errors else "")


def batches(study: Study[Job, Row], jobs: Sequence[Job]) -> list[tuple[Job, ...]]:
    """The jobs in their order, those that are run together in one batch."""
    found: dict[object, list[Job]] = {}
    for place, job in enumerate(jobs):
        group = None if study.together is None else study.together(job)
        found.setdefault(place if group is None else ("together", group), []).append(job)
    return [tuple(batch) for batch in found.values()]


def _announce(
    study: Study[Job, Row],
    jobs: Sequence[Job],
    missing: Sequence[Job],
    worker_count: int,
    job_s: float | None,
) -> None:
    """Says what is about to run and, where jobs have been timed, how long that may take."""
    done = len(jobs) - len(missing)
    text = f"{study.name}: {len(jobs)} {study.unit}{'s' * (len(jobs) != 1)}"
    text += f", {done} of them done" if done else ""
    text += f"; {worker_count or 'no'} worker{'s' * (worker_count != 1)}"
    text += " yet" * (worker_count == 0)
    if job_s is not None and missing:
        duration_s = job_s * len(missing) / max(1, min(worker_count, len(missing)))
        text += f", about {_in_words(duration_s)} ({job_s:.2g} s a {study.unit}, as timed here)"
    print(text, file=sys.stderr, flush=True)


def _in_words(duration_s: float) -> str:
    """A duration to two digits, in the unit that suits it."""
    for unit, length_s in (("h", 3600.0), ("min", 60.0)):
        if duration_s >= 1.5 * length_s:
            return f"{duration_s / length_s:.{1 if duration_s < 10.0 * length_s else 0}f} {unit}"
    return f"{duration_s:.0f} s"
