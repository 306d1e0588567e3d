"""A sweep of the toy trial, here or in a process of its own that can be killed."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from experiments.belt.sweep import run_sweep

from experiments.belt.presets import Preset, expand
from experiments.study.processes import LocalWorkers

CELLS = expand(tracker=["pf", "igpf"], speed_mps=[0.1, 1.2])
PRESET = Preset("toy", "", CELLS, tuple(range(4)))
LONG_PRESET = Preset("long", "", CELLS, tuple(range(60)))

TOY = "toy_trial:run_trial"


def main():
    """Runs `toy` or `long` into FOLDER, with a number of processes or on a Dask scheduler."""
    _, name, folder, workers, video = sys.argv
    preset = {"toy": PRESET, "long": LONG_PRESET}[name]
    try:
        with make_workers(workers) as crew:
            run_sweep(preset, Path(folder), crew, video, TOY)
    except OSError as error:
        sys.exit(str(error))


def make_workers(name):
    if name.isdigit():
        return contextlib.nullcontext(LocalWorkers(int(name)))
    from experiments.study.cluster import DaskWorkers

    return DaskWorkers(name)


def environment():
    """Environment of a new process that can import the toy trial and the project."""
    here = Path(__file__).resolve().parent
    paths = [str(here), str(here.parent.parent), *filter(None, [os.environ.get("PYTHONPATH")])]
    return dict(os.environ, PYTHONPATH=os.pathsep.join(paths), PYTHON=sys.executable)


def start(
    folder,
    workers,
    environment,
    *,
    preset=PRESET,
    video="none",
    wrapper=(),
    prepare=None,
    **settings,
):
    """The sweep in a new process, as the leader of a group that can be killed.

    Args:
        folder: Where it writes.
        workers: Number of processes, or address of a Dask scheduler.
        environment: Environment variables, to which `settings` are added.
        preset: What to run.
        video: As the flag of that name.
        wrapper: Words before the command line.
        prepare: Called in the new process before it begins.
        settings: Variables that steer the toy trial.
    """
    code = "import toy_sweep; toy_sweep.main()"
    arguments = [preset.name, str(folder), str(workers), video]
    return subprocess.Popen(
        [*wrapper, environment["PYTHON"], "-c", code, *arguments],
        env=environment | settings,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=prepare,
    )


def left_by(folder):
    """Bytes of what does not depend on how a sweep ran."""
    return {name: (folder / name).read_bytes() for name in ("trials.csv", "curves.csv.gz")}


def row_count(folder):
    path = folder / "trials.csv"
    return path.read_bytes().count(b"\n") - 1 if path.exists() else -1


def wait_for_rows(folder, process, count):
    while row_count(folder) < count and process.poll() is None:
        time.sleep(0.005)


def children_of(pid):
    """Process ids of what any thread of the process has started and what is still there (Linux)."""
    found = []
    for path in Path(f"/proc/{pid}/task").glob("*/children"):
        with contextlib.suppress(OSError):
            found += map(int, path.read_text().split())
    return found


def kill(pid):
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)


def kill_at_random(folder, begin, workers_of, kill_count, rng):
    """Kills the coordinator or a worker at random moments, and starts the coordinator again.

    Args:
        folder: Where the sweep writes.
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
            wait_for_rows(folder, process, row_count(folder) + 1)
        time.sleep(rng.uniform(0.0, 0.5))
        assert process.poll() is None, process.communicate()[1]
        workers = workers_of(process.pid)
        # A trial whose worker dies three times in one run counts as one that kills its workers.
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
