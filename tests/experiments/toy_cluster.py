"""A Dask scheduler and workers on this machine, as processes that can be killed."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Generator
from pathlib import Path

import toy_study

DEADLY_SEED = 999
"""A job of this seed kills the workers of `cluster`."""


@contextlib.contextmanager
def started(*words: object, **variables: str) -> Generator[subprocess.Popen[bytes], None, None]:
    """A process of Dask's command line; it and what it has started end with the block."""
    process = subprocess.Popen(
        [sys.executable, "-m", "dask", *map(str, words)],
        env=toy_study.environment() | variables,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        yield process
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


@contextlib.contextmanager
def scheduler(folder: Path) -> Generator[tuple[subprocess.Popen[bytes], str], None, None]:
    """A scheduler and its address."""
    path = folder / "scheduler.json"
    flags = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", path)
    with started("scheduler", *flags) as process:
        while process.poll() is None:
            with contextlib.suppress(FileNotFoundError, ValueError):  # not there, half written
                address = json.loads(path.read_text())["address"]
                break
            time.sleep(0.05)
        else:
            raise AssertionError(f"the scheduler ended with {process.returncode}")
        yield process, address


@contextlib.contextmanager
def cluster(folder: Path) -> Generator[tuple[str, Callable[[], list[int]]], None, None]:
    """A scheduler with two workers that are replaced when they die: address, process ids now."""
    from experiments.study.cluster import DaskWorkers

    flags = ("--nthreads", "1", "--nworkers", "2", "--no-dashboard", "--local-directory", folder)
    toy = {"TOY_SLEEP_S": "0.1", "TOY_DEADLY_SEEDS": str(DEADLY_SEED)}
    with (
        scheduler(folder) as (_, address),
        started("worker", address, *flags, **toy) as nanny,
    ):
        with DaskWorkers(address) as workers:
            while workers.count < 2:
                assert nanny.poll() is None
                time.sleep(0.05)
        yield address, lambda: [p for p in toy_study.children_of(nanny.pid) if is_worker(p)]


def is_worker(pid: int) -> bool:
    """Whether it is not multiprocessing's resource tracker."""
    with contextlib.suppress(OSError):
        return b"spawn_main" in Path(f"/proc/{pid}/cmdline").read_bytes()
    return False
