"""Studies for tests of the mechanism: a toy of arithmetic, and any real one with disturbed work.

Disturbed work is slow, raises or is killed where environment variables say so, which spawned
workers inherit:

    TOY_SLEEP_S               seconds that every job takes longer
    TOY_CRASH_SEEDS           seeds of jobs that raise, as 1,2; TOY_CRASH_MESSAGE is what they say
    TOY_DEADLY_SEEDS          seeds of jobs that kill their worker
    TOY_KILL_ONCE             file that does not exist: a job of seed 1 kills its worker once
    TOY_SLOW_ONCE, TOY_SLOW_S file that does not exist: the first job takes so long
    TOY_LOSES_FILMS           seeds of jobs that end otherwise when they are filmed

`start` runs a study in a process that can be killed.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from experiments.report.report import Report
from experiments.study.processes import LocalWorkers
from experiments.study.rows import JobOutcome
from experiments.study.run import Options, Summary, run
from experiments.study.study import Result, Results, Score, Study, load

TOY = "toy/sums"
SELECTION = {"methods": ["pf", "igpf"], "seeds": [0, 1, 2, 3, 4, 5]}
JOB_COUNT = 12
LONG = {"methods": ["pf", "igpf"], "seeds": [*range(120)]}
LONG_COUNT = 240
SETTINGS = {"gain": 1.0}


@dataclass(frozen=True)
class Sum:
    """A job: a method and a seed."""

    method: str
    seed: int

    def __str__(self) -> str:
        return f"{self.method}, seed {self.seed}"


@dataclass(frozen=True)
class SumRow:
    """What a part of a sum came to; a job leaves two of them."""

    method: str
    seed: int
    part: str
    outcome: JobOutcome
    value: float | None
    detail: str = ""


def add(job: Sum) -> Result[SumRow]:
    """Rows, curves and a file that depend on the job alone."""
    values = {"half": len(job.method) + job.seed / 7, "whole": 2 * len(job.method) + job.seed / 3.5}
    curve = "".join(f"{job.method},{job.seed},{k},{k * values['half']:.9g}\n" for k in range(3))
    return Result(
        rows=tuple(SumRow(job.method, job.seed, p, "done", v) for p, v in values.items()),
        curves={"curves": curve},
        files={f"notes/{job.method}/{job.seed}.txt": f"{job}\n"},
    )


def run_sums(jobs: Sequence[Sum]) -> list[Result[SumRow]]:
    """Adds each sum."""
    return [add(job) for job in jobs]


def sums(selection: dict[str, Any]) -> list[Sum]:
    """Every seed of a method, then the next method."""
    return [Sum(method, seed) for method in selection["methods"] for seed in selection["seeds"]]


def settings(job: Sum) -> dict[str, object]:
    """The settings of a method."""
    return {f"method {job.method}": {"gain": SETTINGS["gain"]}}


def seed_of(job: Any) -> int:
    """The seed of a job of any study; rows of the toy stand by it."""
    holders = (job, *(getattr(job, name, None) for name in ("config", "world")))
    return next(found.seed for found in holders if hasattr(found, "seed"))


def is_odd(rows: list[SumRow]) -> bool:
    """Odd seeds fail."""
    return rows[0].seed % 2 == 1


def score(row: SumRow) -> tuple[int, float] | None:
    """The whole value at a seed."""
    return None if row.value is None or row.part == "half" else (row.seed, row.value)


def film(job: Sum, path: Path) -> str:
    """A film of a sum."""
    disturb(job)
    if str(job.seed) in os.environ.get("TOY_LOSES_FILMS", "").split(","):
        return "error"
    path.write_text(f"film of {job}")
    return "done"


def report(results: Results[SumRow]) -> Report:
    """The number of rows in words."""
    return Report(f"{len(results.rows)} rows", ())


def disturb(job: Any) -> None:
    """Does to the process of a job what the environment says."""
    time.sleep(float(os.environ.get("TOY_SLEEP_S", "0")))
    seed = str(seed_of(job))
    if seed in os.environ.get("TOY_CRASH_SEEDS", "").split(","):
        message = os.environ.get("TOY_CRASH_MESSAGE", "the toy broke,\non purpose")
        raise ZeroDivisionError(message)
    if seed in os.environ.get("TOY_DEADLY_SEEDS", "").split(","):
        os.kill(os.getpid(), signal.SIGKILL)
    if seed == "1" and _is_first("TOY_KILL_ONCE"):
        os.kill(os.getpid(), signal.SIGKILL)
    if _is_first("TOY_SLOW_ONCE"):
        time.sleep(float(os.environ["TOY_SLOW_S"]))


def _is_first(variable: str) -> bool:
    """True for the first job of all processes that gets here; the variable names a marker."""
    path = os.environ.get(variable)
    try:
        return path is not None and Path(path).touch(exist_ok=False) is None
    except FileExistsError:
        return False


def __getattr__(name: str) -> Any:
    """The work at an import path with disturbances: `toy_study:module:function`."""
    if ":" not in name:
        raise AttributeError(name)

    def disturbed(jobs: Sequence[Any]) -> Any:
        for job in jobs:
            disturb(job)
        return load(name)(jobs)

    return disturbed


@dataclass(frozen=True)
class ThisProcess:
    """No worker at all: the work is done here, one task after the other."""

    count: int = 1

    def run_all(self, work: Any, tasks: Any) -> Iterator[Any]:
        """Yields the answers in their order."""
        yield from map(work, tasks)


STUDY = Study(
    name=TOY,
    unit="sum",
    row=SumRow,
    key=("method", "seed"),
    jobs=sums,
    work="toy_study:toy_study:run_sums",
    settings=settings,
    report="toy_study:report",
    title=str,
    method="method",
    score=Score(score, "value", higher_is_better=True),
    order=seed_of,
    curves={"curves": "method,seed,step,height\n"},
    is_failure=is_odd,
    film="toy_study:film",
)


def get_study(name: str) -> Study[Any, Any]:
    """The toy, or a real study with disturbed work."""
    if name == TOY:
        return STUDY
    from experiments import studies

    study = studies.get_study(name)
    return replace(study, work=f"toy_study:{study.work}")


def run_toy(
    folder: Path,
    selection: dict[str, Any] = SELECTION,
    *,
    study: Study[Any, Any] = STUDY,
    workers: int = 0,
    **options: Any,
) -> Summary:
    """Runs the toy, with so many processes or in this one."""
    crew = LocalWorkers(workers) if workers else ThisProcess()
    return run(study, selection, folder, crew, Options(**options))


def main() -> None:
    """Runs a study as `start` says it."""
    _, name, selection, folder, workers, video = sys.argv
    try:
        with make_workers(workers) as crew:
            options = Options(video=video)  # pyright: ignore[reportArgumentType]
            run(get_study(name), json.loads(selection), Path(folder), crew, options)
    except OSError as error:
        sys.exit(str(error))


def make_workers(name: str) -> Any:
    """So many processes, or the workers of a Dask scheduler."""
    if name.isdigit():
        return contextlib.nullcontext(LocalWorkers(int(name)))
    from experiments.study.cluster import DaskWorkers

    return DaskWorkers(name)


def environment() -> dict[str, str]:
    """Environment of a new process that can import the toy and the project."""
    here = Path(__file__).resolve().parent
    paths = [str(here), str(here.parent.parent), *filter(None, [os.environ.get("PYTHONPATH")])]
    return dict(os.environ, PYTHONPATH=os.pathsep.join(paths), PYTHON=sys.executable)


def start(
    folder: Path,
    workers: object,
    *,
    name: str = TOY,
    selection: dict[str, Any] = SELECTION,
    video: str = "none",
    wrapper: tuple[str, ...] = (),
    prepare: Any = None,
    **variables: str,
) -> subprocess.Popen[str]:
    """The study in a new process, as the leader of a group that can be killed.

    Args:
        folder: Where it writes.
        workers: Number of processes, or address of a Dask scheduler.
        name: Name of the study.
        selection: What to run of it.
        video: As the flag of that name.
        wrapper: Words before the command line.
        prepare: Called in the new process before it begins.
        variables: Environment variables that disturb it.
    """
    code = "import toy_study; toy_study.main()"
    arguments = [name, json.dumps(selection), str(folder), str(workers), video]
    return subprocess.Popen(
        [*wrapper, sys.executable, "-c", code, *arguments],
        env=environment() | variables,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=prepare,
    )


def left_by(folder: Path) -> dict[str, bytes]:
    """Bytes of what does not depend on how a study ran."""
    own = {"timings.csv", "manifest.json", ".lock"}
    apart = {"errors", "videos", "tables", "figures"}
    found = {path.relative_to(folder): path for path in sorted(folder.rglob("*"))}
    return {
        name.as_posix(): path.read_bytes()
        for name, path in found.items()
        if path.is_file() and name.name not in own and name.parts[0] not in apart
    }


def timed_jobs(folder: Path) -> list[str]:
    """The beginnings of the lines of `timings.csv`, all but the time."""
    lines = (folder / "timings.csv").read_text().splitlines()[1:]
    return [line.rpartition(",")[0] for line in lines]


def job_count(folder: Path) -> int:
    """Jobs of which a folder holds something, also while it is written to."""
    journal, timings = folder / "journal.jsonl", folder / "timings.csv"
    lines = journal.read_bytes().count(b"\n") if journal.exists() else 0
    return lines + max(0, timings.read_bytes().count(b"\n") - 1 if timings.exists() else 0)


def wait_for_jobs(folder: Path, process: subprocess.Popen[str], count: int) -> None:
    """Waits until a folder holds so many jobs, or the process has ended."""
    while job_count(folder) < count and process.poll() is None:
        time.sleep(0.005)


def children_of(pid: int) -> list[int]:
    """Process ids of what any thread of the process has started and what is still there (Linux)."""
    found: list[int] = []
    for path in Path(f"/proc/{pid}/task").glob("*/children"):
        with contextlib.suppress(OSError):
            found += map(int, path.read_text().split())
    return found


def kill(pid: int) -> None:
    """Kills a process that may have ended."""
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)


def kill_group(process: subprocess.Popen[str]) -> None:
    """Kills a process that leads a group, with all that it has started, and waits for it."""
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()


def kill_at_random(
    folder: Path, begin: Any, workers_of: Any, kill_count: int, rng: Any
) -> tuple[int, int]:
    """Kills the coordinator or a worker at random moments, and starts the coordinator again.

    Args:
        folder: Where the study writes.
        begin: Starts the coordinator.
        workers_of: Process ids of the workers, given that of the coordinator.
        kill_count: Number of kills.
        rng: Draws moments and victims.

    Returns: kills of workers, kills of the coordinator.
    """
    kills = {"worker": 0, "coordinator": 0}
    process, worker_kills_in_a_row = begin(), 0
    while sum(kills.values()) < kill_count:
        if rng.random() < 0.7:  # else it may be hit while it starts
            wait_for_jobs(folder, process, job_count(folder) + 1)
        time.sleep(rng.uniform(0.0, 0.5))
        assert process.poll() is None, process.communicate()[1]
        workers = workers_of(process.pid)
        # A job whose worker dies three times in one run counts as one that kills its workers.
        if workers and worker_kills_in_a_row < 2 and rng.random() < 0.6:
            kill(int(rng.choice(workers)))
            kills["worker"] += 1
            worker_kills_in_a_row += 1
        else:
            process.kill()
            process.communicate()
            kills["coordinator"] += 1
            process, worker_kills_in_a_row = begin(), 0
    process.kill()
    process.communicate()
    return kills["worker"], kills["coordinator"]
