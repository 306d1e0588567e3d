"""Trials in spawned worker processes: one OpenGL context and one thread each.

A worker that dies (killed, out of memory, a fault in a driver) costs only the trial it ran; it is
replaced, and the trial is tried once more. One worker is used in the same way as several.
"""

from __future__ import annotations

import contextlib
import importlib
import multiprocessing
import os
import signal
import sys
import time
import traceback
from collections import deque
from collections.abc import Generator, Sequence
from dataclasses import dataclass, field
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from pathlib import Path

from experiments import records
from experiments.config import TrialConfig, TrialResult, TrialTimings

RUN_TRIAL = "experiments.trial:run_trial"
"""Import path of the function that runs a trial; a path, so that a new process can find it."""

SINGLE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "OPENCV_FOR_THREADS_NUM": "1",
    "LP_NUM_THREADS": "0",
}
"""Linear algebra, OpenCV and Mesa's llvmpipe on the calling thread: fastest, and repeatable."""

_TRIES = 2


@dataclass(frozen=True)
class Attempt:
    """What one trial left: its rows and, where it crashed, why."""

    index: int
    """Place of the trial in the sweep."""
    result: TrialResult
    timings: TrialTimings
    crash: str | None = None
    """Traceback of a trial that crashed."""


@dataclass(frozen=True)
class TrialJob:
    """What every worker of a sweep is told."""

    preset: str
    provenance: dict[str, str]
    """`commit` and `mujoco_version`, for the rows of crashed trials."""
    run_trial: str = RUN_TRIAL

    def crashed(self, task: _Task, detail: str, crash: str) -> Attempt:
        """The attempt of a trial that ended in an error: `detail` in a line, `crash` in full."""
        provenance = {"preset": self.preset} | self.provenance
        result = records.error_result(task.config, detail, provenance)
        timings = records.error_timings(task.config, time.perf_counter() - task.started_s)
        return Attempt(task.index, result, timings, crash)


def limit_threads() -> None:
    """One thread for everything in this process; call it before the first heavy import."""
    os.environ.update(SINGLE_THREAD)
    if "cv2" in sys.modules:
        sys.modules["cv2"].setNumThreads(1)


def attempt(
    job: TrialJob, index: int, config: TrialConfig, video_path: Path | None = None
) -> Attempt:
    """Runs one trial in this process; an exception becomes a row with outcome=error."""
    task = _Task(index, config)
    try:
        module, name = job.run_trial.split(":")
        run_trial = getattr(importlib.import_module(module), name)
        result, timings = run_trial(config, video_path=video_path, preset=job.preset)
        for row in (result, timings):
            if row.trial_id != config.trial_id:
                raise RuntimeError(f"trial {config.trial_id} returned a row of {row.trial_id}")
            records.row_line(row)
    except Exception as error:
        return job.crashed(task, f"{type(error).__name__}: {error}", traceback.format_exc())
    return Attempt(index, result, timings)


def run_all(
    job: TrialJob, trials: Sequence[tuple[int, TrialConfig]], worker_count: int
) -> Generator[Attempt, None, None]:
    """Yields the attempts as they end, in any order; closing the iterator stops the workers."""
    waiting = deque(_Task(index, config) for index, config in trials)
    idle: list[_Worker] = []
    busy: dict[Connection, _Worker] = {}
    try:
        while waiting or busy:
            while waiting and len(busy) < worker_count:
                worker = idle.pop() if idle else _Worker(job)
                busy[worker.connection] = worker
                worker.give(waiting.popleft())
            ready = wait(list(busy))
            for worker in [worker for worker in busy.values() if worker.connection in ready]:
                del busy[worker.connection]
                done, task = worker.take(), worker.task
                if done is not None:
                    idle.append(worker)
                    yield done
                elif task.try_count < _TRIES:
                    waiting.appendleft(task)
                else:
                    yield task.lost(job, worker.exit_remark)
    finally:
        for worker in [*idle, *busy.values()]:
            worker.stop()


@dataclass
class _Task:
    """One trial on its way through the workers."""

    index: int
    config: TrialConfig
    try_count: int = 0
    started_s: float = field(default_factory=time.perf_counter)

    def lost(self, job: TrialJob, remark: str) -> Attempt:
        """The attempt of a trial whose worker died every time."""
        remark = f"worker process died {self.try_count} times, the last time by {remark}"
        return job.crashed(self, remark, remark)


class _Worker:
    """One spawned process and the trial it is given."""

    task: _Task
    is_busy = False

    def __init__(self, job: TrialJob) -> None:
        context = multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe()
        self.connection: Connection = ours
        self._process = context.Process(target=_serve, args=(theirs, job), daemon=True)
        # Its start would unblock the interrupt that `_quiet_start` holds back.
        resource_tracker.ensure_running()
        with _quiet_start():
            self._process.start()
        theirs.close()

    def give(self, task: _Task) -> None:
        """Starts the trial; a worker that died meanwhile shows at the next `take`."""
        self.task, self.is_busy = task, True
        task.try_count += 1
        task.started_s = time.perf_counter()
        with contextlib.suppress(OSError):
            self.connection.send((task.index, task.config))

    def take(self) -> Attempt | None:
        """The attempt that is ready; None if the process died instead."""
        self.is_busy = False
        try:
            return self.connection.recv()
        except (EOFError, OSError):
            self._process.join()
            return None

    @property
    def exit_remark(self) -> str:
        """How the process ended."""
        code = self._process.exitcode or 0
        return signal.Signals(-code).name if code < 0 else f"exit code {code}"

    def stop(self) -> None:
        """Ends the process: in order when idle, at once in the middle of a trial."""
        self.connection.close()
        if self.is_busy:
            self._process.terminate()
        self._process.join(timeout=3.0)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


@contextlib.contextmanager
def _quiet_start() -> Generator[None, None, None]:
    """A process started inside inherits single-thread settings and a blocked interrupt.

    Ctrl-C reaches every process of the terminal; only the parent is to answer it.
    """
    before = {name: os.environ.get(name) for name in SINGLE_THREAD}
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    os.environ.update(SINGLE_THREAD)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def _serve(connection: Connection, job: TrialJob) -> None:
    """Main function of a worker: runs trials until the other end is closed."""
    limit_threads()
    with contextlib.suppress(EOFError, OSError):
        while True:
            index, config = connection.recv()
            connection.send(attempt(job, index, config))
