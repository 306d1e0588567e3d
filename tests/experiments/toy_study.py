"""Studies for tests of the mechanism: a toy of arithmetic, and small selections of the real ones.

`Disturbed` work is slow, raises or is killed where environment variables say so, which spawned
workers inherit; `python -c "import toy_study; toy_study.main()"` runs a study in a process that can
be killed.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from experiments import studies
from experiments.study.processes import LocalWorkers
from experiments.study.rows import JobOutcome
from experiments.study.run import Options, run
from experiments.study.study import Each, Result, Score, Study

TOY = "toy/sums"


@dataclass(frozen=True)
class Sum:
    """A job: a method and a seed."""

    method: str
    seed: int

    def __str__(self) -> str:
        return f"{self.method}, seed {self.seed}"


@dataclass(frozen=True)
class SumRow:
    """What a sum came to."""

    method: str
    seed: int
    outcome: JobOutcome
    value: float | None
    detail: str = ""


def add(job: Sum) -> Result[SumRow]:
    """A row, a curve and a file that depend on the job alone."""
    value = len(job.method) + job.seed / 7
    curve = "".join(f"{job.method},{job.seed},{k},{k * value:.9g}\n" for k in range(3))
    row = SumRow(job.method, job.seed, "done", value)
    return Result((row,), curves={"curves": curve}, files={f"notes/{job.method}{job.seed}": "x"})


def sums(selection: dict[str, Any]) -> list[Sum]:
    """Every seed of a method, then the next method."""
    return [Sum(method, seed) for method in selection["methods"] for seed in selection["seeds"]]


def settings(job: Sum) -> dict[str, object]:
    """The settings of a method."""
    return {f"method {job.method}": {"gain": SETTINGS["gain"]}}


def seed_of(job: Sum) -> int:
    """Rows stand by seed."""
    return job.seed


def is_odd(rows: list[SumRow]) -> bool:
    """Odd seeds fail."""
    return rows[0].seed % 2 == 1


def score(row: SumRow) -> tuple[int, float] | None:
    """The value at a seed."""
    return None if row.value is None else (row.seed, row.value)


def film(job: Sum, path: Path) -> str:
    """A film of a sum."""
    if os.environ.get("TOY_LOSES_FILMS"):
        return "error"
    path.write_text(f"film of {job}")
    return "done"


SETTINGS = {"gain": 1.0}

STUDY = Study(
    name=TOY,
    unit="sum",
    row=SumRow,
    key=("method", "seed"),
    jobs=sums,
    work=Each(add),
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
SELECTION = {"methods": ["pf", "igpf"], "seeds": [0, 1, 2, 3]}


def get_study(name: str) -> Study[Any, Any]:
    """The toy, or a real study."""
    return STUDY if name == TOY else studies.get_study(name)


@dataclass(frozen=True)
class Disturbed:
    """The work of a study, which the environment may slow down, break or kill."""

    work: Any

    def __call__(self, jobs: tuple[Any, ...]) -> Any:
        """What the work returns, if it gets so far."""
        time.sleep(float(os.environ.get("TOY_SLEEP_S", "0")))
        for job in jobs:
            seed = str(getattr(job, "seed", None) or getattr(job, "config", job).seed)
            if seed in os.environ.get("TOY_CRASH_SEEDS", "").split(","):
                raise ZeroDivisionError("the toy broke,\non purpose")
            if seed in os.environ.get("TOY_DEADLY_SEEDS", "").split(","):
                os.kill(os.getpid(), signal.SIGKILL)
            if seed == "1" and _is_first("TOY_KILL_ONCE"):
                os.kill(os.getpid(), signal.SIGKILL)
        if _is_first("TOY_SLOW_ONCE"):
            time.sleep(float(os.environ["TOY_SLOW_S"]))
        return self.work(jobs)


def _is_first(variable: str) -> bool:
    """True for the first job of all processes that gets here; the variable names a marker."""
    path = os.environ.get(variable)
    try:
        return path is not None and Path(path).touch(exist_ok=False) is None
    except FileExistsError:
        return False


def disturbed(name: str) -> Study[Any, Any]:
    """The study of that name with disturbed work."""
    study = get_study(name)
    return replace(study, work=Disturbed(study.work))


def main() -> None:
    """Runs STUDY into FOLDER with a number of processes or on a Dask scheduler."""
    import json

    _, name, selection, folder, workers, video = sys.argv
    try:
        with make_workers(workers) as crew:
            run(disturbed(name), json.loads(selection), Path(folder), crew, Options(video=video))  # pyright: ignore[reportArgumentType]
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
    **variables: str,
) -> subprocess.Popen[str]:
    """The study in a new process, as the leader of a group that can be killed."""
    import json

    code = "import toy_study; toy_study.main()"
    arguments = [name, json.dumps(selection), str(folder), str(workers), video]
    return subprocess.Popen(
        [*wrapper, sys.executable, "-c", code, *arguments],
        env=environment() | variables,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def left_by(folder: Path) -> dict[str, bytes]:
    """Bytes of what does not depend on how a study ran."""
    own = ("timings.csv", "manifest.json", ".lock")
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name not in own and path.parent.name not in ("errors", "videos")
    }


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
