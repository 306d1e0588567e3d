"""Sweeps on a Dask scheduler and its workers, all on this machine."""

import contextlib
import gc
import json
import os
import signal
import socket
import subprocess
import sys
import time

import numpy as np
import pytest
import toy_sweep
from experiments.belt.sweep import run_sweep
from toy_sweep import LONG_PRESET, PRESET, left_by

from experiments.belt.config import TrialResult, TrialTimings
from experiments.belt.presets import Preset
from experiments.study import cluster as dask
from experiments.study import manifest, records
from experiments.study.cluster import DaskWorkers

DEADLY_SEED = 99


@contextlib.contextmanager
def started(environment, *words):
    """A process of Dask's command line; it and what it has started end with the block."""
    command = [environment["PYTHON"], "-m", "dask", *map(str, words)]
    process = subprocess.Popen(
        command,
        env=environment,
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


def scheduler(environment, path):
    """A scheduler that writes its address to the file of that path."""
    flags = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", path)
    return started(environment, "scheduler", *flags)


def address_of(process, path):
    while process.poll() is None:
        with contextlib.suppress(
            FileNotFoundError, json.JSONDecodeError
        ):  # not there, half written
            return json.loads(path.read_text())["address"]
        time.sleep(0.05)
    raise AssertionError(f"the scheduler ended with {process.returncode}")


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """A scheduler with two workers that are replaced when they die: address, process ids now."""
    folder = tmp_path_factory.mktemp("dask")
    toy = {"TOY_SLEEP_S": "0.1", "TOY_DEADLY_SEEDS": str(DEADLY_SEED)}
    environment = toy_sweep.environment() | toy
    path = folder / "scheduler.json"
    flags = ("--nthreads", "1", "--nworkers", "2", "--no-dashboard", "--local-directory", folder)
    with scheduler(environment, path) as head:
        address = address_of(head, path)
        with started(environment, "worker", address, *flags) as nanny:
            with DaskWorkers(address) as workers:
                while workers.count < 2:
                    assert nanny.poll() is None
                    time.sleep(0.05)
            yield (
                address,
                lambda: [pid for pid in toy_sweep.children_of(nanny.pid) if is_dask_worker(pid)],
            )


def is_dask_worker(pid):
    """Whether it is not multiprocessing's resource tracker."""
    with contextlib.suppress(OSError), open(f"/proc/{pid}/cmdline", "rb") as file:
        return b"spawn_main" in file.read()
    return False


def test_a_worker_killed_in_the_middle_changes_no_byte(tmp_path, cluster, unbroken):
    address, workers_now = cluster
    folder = tmp_path / "dask"
    process = toy_sweep.start(folder, address, toy_sweep.environment(), video="failures")
    toy_sweep.wait_for_rows(folder, process, 4)
    victim = workers_now()[0]
    toy_sweep.kill(victim)
    assert toy_sweep.row_count(folder) < len(PRESET.trials)
    _, text = process.communicate(timeout=60)
    assert process.returncode == 0, text
    assert "with 2 workers" in text
    assert victim not in workers_now()
    assert left_by(folder) == unbroken
    timings = records.read_rows(folder / "timings.csv", TrialTimings)
    assert [row.trial_id for row in timings] == [trial.trial_id for trial in PRESET.trials]
    assert manifest.read_manifest(folder)["sessions"][0]["workers"] == 2
    rows = records.read_rows(folder / "trials.csv", TrialResult)
    assert len(list((folder / "videos").iterdir())) == sum(not row.success for row in rows)


@pytest.mark.slow
def test_twenty_kills_of_coordinator_and_workers_change_no_byte(tmp_path, cluster, long_unbroken):
    address, workers_now = cluster
    folder = tmp_path / "killed"
    environment = toy_sweep.environment()

    def begin():
        return toy_sweep.start(folder, address, environment, preset=LONG_PRESET)

    rng = np.random.default_rng(0)
    kills = toy_sweep.kill_at_random(folder, begin, lambda _: workers_now(), 20, rng)
    assert min(kills) > 0
    assert 0 < toy_sweep.row_count(folder) < len(LONG_PRESET.trials)
    _, text = begin().communicate()
    assert left_by(folder) == long_unbroken, text
    timings = records.read_rows(folder / "timings.csv", TrialTimings)
    assert [row.trial_id for row in timings] == [trial.trial_id for trial in LONG_PRESET.trials]


@pytest.mark.slow
def test_a_trial_that_kills_its_workers_is_a_row(tmp_path, cluster):
    address, _ = cluster
    preset = Preset("toy", "", PRESET.cells[:1], (0, DEADLY_SEED, 1, 2))
    with DaskWorkers(address) as workers:
        done = run_sweep(preset, tmp_path / "dask", workers, run_trial=toy_sweep.TOY)
    assert done.error_count == 1
    rows = records.read_rows(done.trials_path, TrialResult)
    assert rows[1].detail == "worker process died 8 times"


@pytest.mark.slow
def test_a_lost_scheduler_is_one_line_and_the_sweep_goes_on_later(tmp_path):
    environment, folder = toy_sweep.environment(), tmp_path / "dask"
    with scheduler(environment, tmp_path / "scheduler.json") as process:
        address = address_of(process, tmp_path / "scheduler.json")
        sweep = toy_sweep.start(folder, address, environment)
        while not (folder / "timings.csv").exists() and sweep.poll() is None:
            time.sleep(0.01)
        time.sleep(0.3)
        process.kill()
        _, text = sweep.communicate(timeout=60)
    assert sweep.returncode == 1
    assert "with no workers yet" in text
    assert text.splitlines()[-1] == (
        f"the Dask scheduler at {address} is lost; 0 of 16 trials are kept in {folder}, "
        "and the same command resumes"
    )


def test_an_address_where_no_scheduler_answers_is_one_line_in_seconds(monkeypatch):
    assert dask.CONNECT_TIMEOUT_S <= 5.0
    monkeypatch.setattr(dask, "CONNECT_TIMEOUT_S", 1.0)
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{unused.getsockname()[1]}"
        started_s = time.monotonic()
        with pytest.raises(OSError, match=f"no Dask scheduler answers at {address}"):
            DaskWorkers(address)
    assert time.monotonic() - started_s < 4.0


@pytest.mark.parametrize("address", ["nonsense", "tcp://", "carrier-pigeon://here:1"])
def test_what_is_no_address_is_told(address):
    """And the client that failed is gone: collected later it may stop in the midst of the next."""
    with pytest.raises(OSError, match=f"no Dask scheduler answers at {address}"):
        DaskWorkers(address)
    clients = [c for c in gc.get_objects() if type(c) is dask.distributed.Client]
    assert all(client.status == "closed" for client in clients)


@pytest.mark.parametrize(
    ("thread_count", "message"),
    [
        (1, r"runs {'commit': 'old'}, this sweep is of {'commit': 'new'}"),
        (2, r"has 2 threads, .* start workers with --nthreads 1"),
    ],
)
def test_workers_that_are_not_fit_are_refused(tmp_path, monkeypatch, thread_count, message):
    monkeypatch.setattr(dask, "limit_threads", lambda: None)
    versions = iter([{"commit": "new"}] * 2)
    monkeypatch.setattr(manifest, "provenance", lambda: next(versions, {"commit": "old"}))
    settings = {"processes": False, "n_workers": 1, "dashboard_address": ":0"}
    with (
        dask.distributed.Client(**settings, threads_per_worker=thread_count) as local,
        DaskWorkers(local.scheduler.address) as workers,
        pytest.raises(ValueError, match=message),
    ):
        run_sweep(PRESET, tmp_path / "dask", workers, run_trial=toy_sweep.TOY)


def test_without_the_extra_one_line_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    monkeypatch.delitem(sys.modules, "experiments.study.cluster")
    with pytest.raises(
        ValueError,
        match=r"dask needs the extra `cluster` .*: uv sync --inexact --extra cluster, or pip",
    ):
        import experiments.study.cluster  # noqa: F401
