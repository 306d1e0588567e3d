"""Tasks in spawned worker processes of one thread each; the answers come in any order.

A worker that dies (killed, out of memory, a fault in a driver) costs only the task it had; it is
replaced, and the task is tried again. One worker is used in the same way as several.
"""

import contextlib
import multiprocessing
import os
import signal
import sys
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable
from dataclasses import dataclass, field
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from typing import Any, Generic, Protocol, TypeVar

Task = TypeVar("Task")
Answer = TypeVar("Answer")

SINGLE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "OPENCV_FOR_THREADS_NUM": "1",
    "LP_NUM_THREADS": "0",
}
"""Linear algebra, OpenCV and Mesa's llvmpipe on the calling thread: fastest, and repeatable."""

_TRIES = 3
"""A task that was twice unlucky is not yet taken for one that kills its workers."""


@dataclass(frozen=True)
class Lost(Generic[Task]):
    """A task whose worker died every time it was tried."""

    task: Task
    remark: str
    """How often its workers died, and of what the last one."""
    wall_s: float
    """Duration of the last try [s]."""


def limit_threads() -> None:
    """One thread for everything in this process; call it before the first heavy import."""
    os.environ.update(SINGLE_THREAD)
    if "cv2" in sys.modules:
        sys.modules["cv2"].setNumThreads(1)


class Workers(Protocol):
    """Those who do the work: processes of this machine, or of a cluster."""

    @property
    def count(self) -> int:
        """How many there are now."""
        ...

    def run_all(
        self, work: Callable[[Task], Answer], tasks: Iterable[Task]
    ) -> Generator[Answer | Lost[Task], None, None]:
        """Yields the answers as they come, in any order; closing the iterator stops the work."""
        ...


@dataclass(frozen=True)
class LocalWorkers:
    """Processes of this machine."""

    count: int

    def __post_init__(self) -> None:
        if self.count < 1:
            raise ValueError(f"workers must be 1 or greater, got {self.count}")

    def run_all(
        self, work: Callable[[Task], Answer], tasks: Iterable[Task]
    ) -> Generator[Answer | Lost[Task], None, None]:
        """Yields the answers as they come, in any order; closing the iterator stops the workers.

        Args:
            work: Answers a task; must be picklable, and an exception that it raises ends its
                worker.
            tasks: Picklable, begun in this order.
        """
        waiting = deque(_Turn(task) for task in tasks)
        idle: list[_Worker[Task, Answer]] = []
        busy: dict[Connection, _Worker[Task, Answer]] = {}
        try:
            while waiting or busy:
                while waiting and len(busy) < self.count:
                    worker = idle.pop() if idle else _Worker[Task, Answer](work)
                    busy[worker.connection] = worker
                    worker.give(waiting.popleft())
                ready = wait(list(busy))
                for worker in [worker for worker in busy.values() if worker.connection in ready]:
                    del busy[worker.connection]
                    answers, turn = worker.take(), worker.turn
                    if answers:
                        idle.append(worker)
                        yield answers[0]
                    elif turn.try_count < _TRIES:
                        waiting.appendleft(turn)
                    else:
                        yield turn.lost(worker.exit_remark)
        finally:
            for worker in [*idle, *busy.values()]:
                worker.stop()


@dataclass
class _Turn(Generic[Task]):
    """One task on its way through the workers."""

    task: Task
    try_count: int = 0
    started_s: float = field(default_factory=time.perf_counter)

    def lost(self, remark: str) -> Lost[Task]:
        remark = f"worker process died {self.try_count} times, the last time by {remark}"
        return Lost(self.task, remark, time.perf_counter() - self.started_s)


class _Worker(Generic[Task, Answer]):
    """One spawned process and the task it is given."""

    turn: _Turn[Task]
    is_busy = False

    def __init__(self, work: Callable[[Task], Answer]) -> None:
        context = multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe()
        self.connection: Connection = ours
        self._process = context.Process(target=_serve, args=(theirs, work), daemon=True)
        # Its start would unblock the interrupt that `_quiet_start` holds back.
        resource_tracker.ensure_running()
        with _quiet_start():
            self._process.start()
        theirs.close()

    def give(self, turn: _Turn[Task]) -> None:
        """Starts the task; a worker that died meanwhile shows at the next `take`."""
        self.turn, self.is_busy = turn, True
        turn.try_count += 1
        turn.started_s = time.perf_counter()
        with contextlib.suppress(OSError):
            self.connection.send(turn.task)

    def take(self) -> list[Answer]:
        """The answer that is ready; none if the process died instead."""
        self.is_busy = False
        try:
            return [self.connection.recv()]
        except (EOFError, OSError):
            self._process.join()
            return []

    @property
    def exit_remark(self) -> str:
        """How the process ended."""
        code = self._process.exitcode or 0
        return signal.Signals(-code).name if code < 0 else f"exit code {code}"

    def stop(self) -> None:
        """Ends the process: in order when idle, at once in the middle of a task."""
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


def _serve(connection: Connection, work: Callable[[Any], Any]) -> None:
    """Main function of a worker: answers tasks until the other end is closed."""
    limit_threads()
    with contextlib.suppress(EOFError, OSError):
        while True:
            connection.send(work(connection.recv()))
