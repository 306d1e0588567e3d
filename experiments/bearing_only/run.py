"""Flies what a results folder lacks; the same command again resumes, flight by flight."""

from __future__ import annotations

import contextlib
import sys
import time
import traceback
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tqdm import tqdm

from experiments.bearing_only import folder
from experiments.bearing_only.config import FlightRun, FlightTimings
from experiments.bearing_only.controllers import ORACLES, get_controller
from experiments.bearing_only.flying import fly
from experiments.bearing_only.folder import Left
from experiments.bearing_only.scores import failed_result, results_of
from experiments.bearing_only.traces import curve_of, is_traced, map_of, trace_name, trace_of
from experiments.study import manifest
from experiments.study.processes import Lost, Workers
from experiments.study.progress import progress_bar
from experiments.study.records import row_line
from experiments.study.results_folder import exclusive


@dataclass(frozen=True)
class Task:
    """Flights that go on at once: one, or all seeds of an oracle's cell."""

    runs: tuple[FlightRun, ...]


@dataclass(frozen=True)
class FlightJob:
    """What every worker is told."""

    commit: str

    def __call__(self, task: Task) -> list[Left]:
        """What the flights of the task leave; an exception becomes rows with outcome=error."""
        started_s = time.perf_counter()
        try:
            return self._fly(task)
        except Exception as error:
            wall_s = time.perf_counter() - started_s
            detail = f"{type(error).__name__}: {error}"
            return self.crashed(task, wall_s, detail, traceback.format_exc())

    def crashed(self, task: Task, wall_s: float, detail: str, crash: str) -> list[Left]:
        """Rows of flights that ended in an error."""
        n = len(task.runs)
        return [
            Left(
                row_line(failed_result(run, "error", detail, self.commit)),
                row_line(FlightTimings(run.run_id, run.controller, None, None, n, wall_s)),
                "",
                crash,
            )
            for run in task.runs
        ]

    def _fly(self, task: Task) -> list[Left]:
        started_s = time.perf_counter()
        flown = fly(task.runs)
        results = results_of(task.runs, flown, self.commit)
        wall_s = time.perf_counter() - started_s
        step_ms = 1e3 * np.array(flown.log.step_s or [np.nan])
        median_ms, p95_ms = float(np.median(step_ms)), float(np.percentile(step_ms, 95))
        crash = None
        if flown.error is not None:
            crash = "".join(traceback.format_exception(flown.error))
        left: list[Left] = []
        for index, (run, result) in enumerate(zip(task.runs, results, strict=True)):
            timings = FlightTimings(
                run.run_id, run.controller, median_ms, p95_ms, len(task.runs), wall_s
            )
            traces: list[tuple[str, str]] = []
            if is_traced(run) and flown.log.is_seen:
                traces.append((f"{trace_name(run)}.csv", trace_of(flown.log, index)))
                if (landmarks := map_of(flown)) is not None:
                    traces.append((f"{trace_name(run)}_map.csv", landmarks))
            curve = curve_of(run, flown.log, index)
            left.append(Left(row_line(result), row_line(timings), curve, crash, tuple(traces)))
        return left


def run_flights(runs: Sequence[FlightRun], out: Path, workers: Workers) -> tuple[int, int]:
    """Flies what `out` lacks of the runs, which are of one study.

    Returns: how many of the runs have their row now, and how many of these broke off.
    """
    if not runs:
        raise ValueError("there is nothing to fly: no controller or no seed")
    with exclusive(out):
        done = folder.open_folder(out, runs[0].study, workers.count)
        missing = [run for run in runs if run.run_id not in done]
        try:
            _run_missing(missing, out, workers, len(runs))
        finally:
            folder.put_in_order(out)
    return _count(runs, out)


def _run_missing(missing: Sequence[FlightRun], out: Path, workers: Workers, total: int) -> None:
    tasks = list(_tasks(missing))
    already = f", {total - len(missing)} of them done" if len(missing) < total else ""
    count = workers.count
    print(
        f"bearing-only: {total} flights{already}; {count} worker{'s' * (count > 1)}",
        file=sys.stderr,
        flush=True,
    )
    job = FlightJob(str(manifest.code_version()))
    answers = workers.run_all(job, tasks)
    done = total - len(missing)
    with contextlib.closing(answers), progress_bar("flights", "flight", total, done) as bar:
        for answer in answers:
            if isinstance(answer, Lost):
                answer = job.crashed(answer.task, answer.wall_s, answer.remark, answer.remark)
            for left in answer:
                folder.append(out, left)
                if left.crash is not None:
                    tqdm.write(left.crash.rstrip(), file=sys.stderr)
                bar.update()


def _tasks(runs: Sequence[FlightRun]) -> Iterator[Task]:
    """Runs of an oracle that differ in their seed alone fly together."""
    together: dict[tuple[object, ...], list[FlightRun]] = {}
    for run in runs:
        if get_controller(run.controller).pose not in ORACLES:
            yield Task((run,))
            continue
        cell = (run.controller, run.v_max_mps, run.range_prior, run.pose_error, run.pose_error_m)
        together.setdefault(cell, []).append(run)
    for group in together.values():
        yield Task(tuple(group))


def _count(runs: Sequence[FlightRun], out: Path) -> tuple[int, int]:
    ids = {run.run_id for run in runs}
    rows = [row for row in folder.read_results(out) if row.run_id in ids]
    return len(rows), sum(row.outcome == "error" for row in rows)
