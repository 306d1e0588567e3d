"""A study on a Dask scheduler and its workers, all on this machine."""

import gc
import socket
import sys
import time

import numpy as np
import pytest
import toy_study
from toy_cluster import DEADLY_SEED, scheduler
from toy_study import JOB_COUNT, LONG, LONG_COUNT, SELECTION, STUDY, left_by

from experiments.study import cluster as dask
from experiments.study import provenance
from experiments.study.cluster import DaskWorkers
from experiments.study.folder import read_results
from experiments.study.manifest import Manifest
from experiments.study.run import run


def test_a_worker_killed_in_the_middle_changes_no_byte(tmp_path, cluster, unbroken):
    address, workers_now = cluster
    folder = tmp_path / "dask"
    process = toy_study.start(folder, address, video="failures")
    toy_study.wait_for_jobs(folder, process, 4)
    victim = workers_now()[0]
    toy_study.kill(victim)
    assert toy_study.job_count(folder) < JOB_COUNT
    _, text = process.communicate(timeout=60)
    assert process.returncode == 0, text
    assert "toy/sums: 12 sums; 2 workers" in text
    assert victim not in workers_now()
    assert left_by(folder) == unbroken
    assert len(toy_study.timed_jobs(folder)) == JOB_COUNT
    assert Manifest.read(folder).sessions[0]["workers"] == 2
    assert len(list((folder / "videos").iterdir())) == JOB_COUNT // 2


@pytest.mark.slow
def test_twenty_kills_of_coordinator_and_workers_change_no_byte(tmp_path, cluster, long_unbroken):
    address, workers_now = cluster
    folder = tmp_path / "killed"

    def begin():
        return toy_study.start(folder, address, selection=LONG)

    rng = np.random.default_rng(0)
    kills = toy_study.kill_at_random(folder, begin, lambda _: workers_now(), 20, rng)
    assert min(kills) > 0
    assert 0 < toy_study.job_count(folder) < LONG_COUNT
    _, text = begin().communicate()
    assert left_by(folder) == long_unbroken, text
    assert len(toy_study.timed_jobs(folder)) == LONG_COUNT


@pytest.mark.slow
def test_a_job_that_kills_its_workers_is_a_row(tmp_path, cluster):
    address, _ = cluster
    selection = {"methods": ["pf"], "seeds": [0, DEADLY_SEED, 1, 2]}
    with DaskWorkers(address) as workers:
        done = run(STUDY, selection, tmp_path / "dask", workers)
    assert done.error_count == 1
    (row,) = (r for r in read_results(tmp_path / "dask", STUDY).rows if r.outcome == "error")
    assert (row.seed, row.detail) == (DEADLY_SEED, "worker process died 8 times")


@pytest.mark.slow
def test_a_lost_scheduler_is_one_line_and_the_run_goes_on_later(tmp_path):
    folder = tmp_path / "dask"
    with scheduler(tmp_path) as (process, address):
        study = toy_study.start(folder, address)
        while not (folder / "rows.csv").exists() and study.poll() is None:
            time.sleep(0.01)
        time.sleep(0.3)
        process.kill()
        _, text = study.communicate(timeout=60)
    assert study.returncode == 1
    assert "no workers yet" in text
    assert text.splitlines()[-1] == (
        f"the Dask scheduler at {address} is lost; 0 of 12 are kept in {folder}, "
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
    assert time.monotonic() - started_s < 25.0, "Dask's own patience is 30 s"


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
        (1, r"runs {'commit': 'old'}, this study is of {'commit': 'new'}"),
        (2, r"has 2 threads, .* start workers with --nthreads 1"),
    ],
)
def test_workers_that_are_not_fit_are_refused(tmp_path, monkeypatch, thread_count, message):
    monkeypatch.setattr(dask, "limit_threads", lambda: None)
    versions = iter([{"commit": "new"}] * 2)
    monkeypatch.setattr(provenance, "provenance", lambda: next(versions, {"commit": "old"}))
    settings = {"processes": False, "n_workers": 1, "dashboard_address": ":0"}
    with (
        dask.distributed.Client(**settings, threads_per_worker=thread_count) as local,
        DaskWorkers(local.scheduler.address) as workers,
        pytest.raises(ValueError, match=message),
    ):
        run(STUDY, SELECTION, tmp_path / "dask", workers)


def test_without_the_extra_one_line_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    monkeypatch.delitem(sys.modules, "experiments.study.cluster")
    with pytest.raises(
        ValueError,
        match=r"dask needs the extra `cluster` .*: uv sync --inexact --extra cluster, or pip",
    ):
        import experiments.study.cluster  # noqa: F401
