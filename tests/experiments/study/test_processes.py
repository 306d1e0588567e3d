"""Worker processes: all answers come, whoever dies, and nobody is left behind."""

import os
import time
from pathlib import Path

import pytest

from experiments.study.processes import SINGLE_THREAD, LocalWorkers, Lost


def square(number):
    return number, number * number


def environment_of(name):
    return os.environ.get(name)


def pid_or_end(number):
    """Its process id; the process of number 3 ends instead."""
    if number == 3:
        os._exit(7)
    return os.getpid()


def sleep_long(path):
    Path(path).write_text(str(os.getpid()))
    time.sleep(600.0)


@pytest.mark.parametrize("workers", [LocalWorkers(1), LocalWorkers(3)])
def test_every_task_is_answered_once(workers):
    assert sorted(workers.run_all(square, range(20))) == [(k, k * k) for k in range(20)]
    assert list(workers.run_all(square, [])) == []


def test_a_task_that_ends_its_process_is_lost_and_the_others_are_answered():
    answers = list(LocalWorkers(2).run_all(pid_or_end, range(6)))
    (lost,) = (answer for answer in answers if isinstance(answer, Lost))
    assert lost.task == 3
    assert lost.remark == "worker process died 3 times, the last time by exit code 7"
    assert len(answers) == 6 and os.getpid() not in answers


@pytest.mark.parametrize("name", SINGLE_THREAD)
def test_a_worker_has_one_thread_and_this_process_keeps_its_own(monkeypatch, name):
    monkeypatch.setenv(name, "5")
    assert list(LocalWorkers(1).run_all(environment_of, [name])) == [SINGLE_THREAD[name]]
    assert os.environ[name] == "5"


def test_closing_stops_the_workers_in_the_middle_of_a_task(tmp_path):
    started = tmp_path / "started"
    answers = LocalWorkers(2).run_all(_first_quick, [None, str(started)])
    assert next(answers) is None
    while not started.exists() or not started.read_text():
        time.sleep(0.01)
    pid = int(started.read_text())
    answers.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


def _first_quick(path):
    return None if path is None else sleep_long(path)
