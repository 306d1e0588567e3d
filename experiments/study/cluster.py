"""Tasks on the workers of a Dask scheduler, on this machine or others.

Workers may come, go and die: Dask runs a task again, and only the coordinator writes results.
"""

from __future__ import annotations

import gc
import logging
from collections.abc import Callable, Generator, Iterable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from experiments.study import provenance as origin
from experiments.study.processes import Lost, limit_threads

try:
    import distributed
except ImportError as missing:
    raise ValueError(
        f"dask needs the extra `cluster` ({missing}): "
        "uv sync --inexact --extra cluster, or pip install '.[cluster]'"
    ) from missing

Task = TypeVar("Task")
Answer = TypeVar("Answer")

CONNECT_TIMEOUT_S = 5.0
_ROUNDS = 2
"""Dask also suspects a task that only waited on a worker that died: it gets a second round."""


class DaskWorkers:
    """The workers of a Dask scheduler; a context manager that ends the connection."""

    def __init__(self, address: str) -> None:
        logging.getLogger("distributed").setLevel(logging.CRITICAL)  # we tell it in our own words
        self._address = address
        try:
            self._client: Any = distributed.Client(address, timeout=CONNECT_TIMEOUT_S)
            return
        except (OSError, ValueError) as error:
            reason = str(error)
        # A client that failed ends itself when it is forgotten; at a moment of the collector's own
        # choosing, as within the start of the next one, both would wait for the same lock.
        gc.collect()
        raise OSError(f"no Dask scheduler answers at {address}: {reason}")

    def __enter__(self) -> DaskWorkers:
        return self

    def __exit__(self, *_: object) -> None:
        self._client.close(timeout=CONNECT_TIMEOUT_S)

    @property
    def count(self) -> int:
        """How many there are now; more may come."""
        return len(self._client.nthreads())

    def run_all(
        self, work: Callable[[Task], Answer], tasks: Iterable[Task]
    ) -> Generator[Answer | Lost[Task], None, None]:
        """Yields the answers as they come, in any order; closing the iterator cancels the rest.

        Raises OSError when the scheduler is lost, ValueError when a worker is not fit for it.
        """
        remote, tasks = _Remote(work, origin.provenance()), list(tasks)
        futures = self._client.map(remote, tasks, pure=False)
        turns = {future.key: (future, task, 1) for future, task in zip(futures, tasks, strict=True)}
        completed: Any = distributed.as_completed(futures)
        del futures  # an answer that has been taken is to be forgotten by the cluster
        try:
            for future in completed:
                _, task, round_number = turns.pop(future.key)
                try:
                    yield future.result()
                except distributed.KilledWorker as killed:
                    if round_number < _ROUNDS:
                        again = self._client.submit(remote, task, pure=False)
                        turns[again.key] = again, task, round_number + 1
                        completed.add(again)
                    else:
                        deaths = round_number * (killed.allowed_failures + 1)
                        yield Lost(task, f"worker process died {deaths} times", wall_s=0.0)
                except distributed.CancelledError:
                    raise OSError(f"the Dask scheduler at {self._address} is lost") from None
        finally:
            self._client.cancel([future for future, _, _ in turns.values()])


@dataclass(frozen=True)
class _Remote(Generic[Task, Answer]):
    """The work as it is done in a Dask worker: like that of a process here, or not at all."""

    work: Callable[[Task], Answer]
    provenance: dict[str, str]

    def __call__(self, task: Task) -> Answer:
        limit_threads()
        worker = distributed.get_worker()
        if worker.state.nthreads != 1:
            raise ValueError(
                f"Dask worker {worker.address} has {worker.state.nthreads} threads, and a job "
                "needs a process of its own; start workers with --nthreads 1"
            )
        if origin.provenance() != self.provenance:
            raise ValueError(
                f"Dask worker {worker.address} runs {origin.provenance()}, "
                f"this study is of {self.provenance}"
            )
        return self.work(task)
