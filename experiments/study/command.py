"""What every command that runs a study has in common: its flags, exit codes and closing lines."""

from __future__ import annotations

import abc
import contextlib
import os
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from tyro.conf import arg

if TYPE_CHECKING:
    from experiments.study.processes import Workers
    from experiments.study.run import Summary
    from experiments.study.shard import Shard
    from experiments.study.study import Selection, Study

# Everything heavy is imported inside the commands, so that --help answers at once.

CRASH_EXIT = 1
"""Exit code where something that was asked for is missing from the results."""
USAGE_EXIT = 2
"""Exit code for what the user got wrong."""
INTERRUPT_EXIT = 130
"""Exit code after Ctrl-C."""


@dataclass(frozen=True)
class Plan:
    """What a command is to run."""

    study: Study[Any, Any]
    selection: Selection
    complaints: tuple[str, ...] = ()
    """A line about each thing that was asked for and cannot be run; the rest is run."""


@dataclass(frozen=True, kw_only=True)
class StudyCommand(abc.ABC):
    """Runs a study into a folder; the same command again resumes."""

    out: Annotated[Path | None, arg(metavar="DIR")] = None
    """Results folder; out/STUDY if not given, and out/STUDY-shard-I-of-N for a shard. What it
    holds of the same study stays, and jobs that it lacks are added."""
    seeds: Annotated[int | None, arg(metavar="N")] = None
    """Number of seeds; that of the study if not given."""
    first_seed: Annotated[int, arg(metavar="N")] = 0
    """The lowest seed: choose settings on others (1000 and on) than those that are judged."""
    workers: Annotated[int | None, arg(metavar="N")] = None
    """Worker processes; one for each processor if not given. The results do not depend on it."""
    shard: Annotated[str | None, arg(metavar="I/N")] = None
    """Only the I-th of N parts; `beltgrasp merge` puts them together."""
    dask: Annotated[str | None, arg(metavar="ADDRESS")] = None
    """Runs on the workers of this Dask scheduler, as tcp://HOST:8786, and starts none here."""
    video: Literal["none", "failures", "all"] = "none"
    """Of which jobs videos are made, when all have their rows; the rows do not depend on it."""
    retry: Literal["crashed", "none"] = "crashed"
    """Which jobs are run again that have a row already: those that crashed, or none."""

    @abc.abstractmethod
    def plan(self) -> Plan:
        """What is to be run; ValueError for unknown names."""

    @cached_property
    def folder(self) -> Path:
        """The results folder that is written to."""
        return self.out or _default_folder(self._plan.study.name, self._shard)

    @cached_property
    def _plan(self) -> Plan:
        return self.plan()

    @cached_property
    def _shard(self) -> Shard | None:
        from experiments.study.shard import Shard

        return None if self.shard is None else Shard.parse(self.shard)

    def run(self) -> int:
        """Exit code 0, or 1 if something that was asked for is missing: a row, a video."""
        from experiments.study.processes import limit_threads
        from experiments.study.run import Interrupted, Options, run

        limit_threads()
        study, options = self._plan.study, Options(self._shard, self.retry, self.video)
        for complaint in self._plan.complaints:
            print(f"beltgrasp: error: {' '.join(complaint.split())}", file=sys.stderr)
        with self._workers() as workers:
            if study.needs_rendering:
                from experiments.study.rendering import gl_renderer

                gl_renderer()
            try:
                done = run(study, self._plan.selection, self.folder, workers, options)
            except Interrupted as interrupt:
                print(f"beltgrasp: {interrupt}; the same command resumes", file=sys.stderr)
                return INTERRUPT_EXIT
        return report_summary(study, done, self.folder) or CRASH_EXIT * bool(self._plan.complaints)

    def _workers(self) -> contextlib.AbstractContextManager[Workers]:
        from experiments.study.processes import LocalWorkers

        if self.dask is None:
            return contextlib.nullcontext(LocalWorkers(worker_count(self.workers)))
        if self.workers is not None:
            raise ValueError("workers are those of the Dask scheduler; give --workers or --dask")
        from experiments.study.cluster import DaskWorkers

        return DaskWorkers(self.dask)


def report_summary(study: Study[Any, Any], done: Summary, out: Path) -> int:
    """Prints what a run has left, and returns its exit code."""
    failed = f", {done.failure_count} failed" if done.failure_count else ""
    plural = "s" * (done.job_count != 1)
    print(f"{done.job_count} {study.unit}{plural}{failed}: {done.rows_path}")
    if done.video_count:
        print(f"{done.video_count} videos: {out / 'videos'}")
    print(f"tables and figures: beltgrasp report {out}")
    if done.error_count:
        print(
            f"beltgrasp: {done.error_count} of them crashed; tracebacks: {out / 'errors'}; "
            "the same command tries them again",
            file=sys.stderr,
        )
    return CRASH_EXIT if done.error_count or done.lost_video_count else 0


def split_names(values: Iterable[str]) -> tuple[str, ...]:
    """The words in the values, each once; commas are as good as spaces."""
    return tuple(
        dict.fromkeys(word for value in values for word in value.replace(",", " ").split())
    )


def seed_list(count: int, first: int = 0) -> list[int]:
    """So many seeds from the first on."""
    if count < 1:
        raise ValueError(f"seeds must be 1 or greater, got {count}")
    if first < 0:
        raise ValueError(f"first-seed must be 0 or greater, got {first}")
    return list(range(first, first + count))


def worker_count(wanted: int | None) -> int:
    """The wanted number of processes, or one for each processor that this one may use."""
    if wanted is not None:
        return wanted
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _default_folder(name: str, shard: Any) -> Path:
    subject, _, study = name.partition("/")
    folder = Path("out") / (study if subject == "belt" else f"{subject}-{study}")
    if shard is None:
        return folder
    return folder.with_name(f"{folder.name}-shard-{shard.number}-of-{shard.count}")
