"""Trials in worker processes: one OpenGL context each; a crash becomes a row."""

from __future__ import annotations

import importlib
import time
import traceback
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from pathlib import Path

from experiments.belt.config import TrialConfig, TrialResult, TrialTimings
from experiments.study import records
from experiments.study.processes import Lost, Workers

RUN_TRIAL = "experiments.belt.trial:run_trial"
"""Import path of the function that runs a trial; a path, so that a new process can find it."""


@dataclass(frozen=True)
class Attempt:
    """What one trial left: its rows and, where it crashed, why."""

    index: int
    """Place of the trial in the sweep."""
    result: TrialResult
    timings: TrialTimings
    curve: str = ""
    """Its error curve as lines of CSV."""
    crash: str | None = None
    """Traceback of a trial that crashed."""


@dataclass(frozen=True)
class TrialJob:
    """What every worker of a sweep is told."""

    preset: str
    provenance: dict[str, str]
    """`commit` and `mujoco_version`, for the rows of crashed trials."""
    run_trial: str = RUN_TRIAL

    def __call__(self, trial: tuple[int, TrialConfig]) -> Attempt:
        """The attempt at the trial of that place in the sweep."""
        return attempt(self, *trial)

    def crashed(
        self, trial: tuple[int, TrialConfig], wall_s: float, detail: str, crash: str
    ) -> Attempt:
        """The attempt of a trial that ended in an error: `detail` in a line, `crash` in full."""
        index, config = trial
        provenance = {"preset": self.preset} | self.provenance
        result = records.error_result(config, detail, provenance)
        return Attempt(index, result, records.error_timings(config, wall_s), crash=crash)


def attempt(
    job: TrialJob, index: int, config: TrialConfig, video_path: Path | None = None
) -> Attempt:
    """Runs one trial in this process; an exception becomes a row with outcome=error."""
    started_s = time.perf_counter()
    try:
        module, name = job.run_trial.split(":")
        run_trial = getattr(importlib.import_module(module), name)
        result, timings, curve = run_trial(config, video_path=video_path, preset=job.preset)
        for row in (result, timings):
            if row.trial_id != config.trial_id:
                raise RuntimeError(f"trial {config.trial_id} returned a row of {row.trial_id}")
            records.row_line(row)
    except Exception as error:
        wall_s = time.perf_counter() - started_s
        detail = f"{type(error).__name__}: {error}"
        return job.crashed((index, config), wall_s, detail, traceback.format_exc())
    return Attempt(index, result, timings, curve)


def run_all(
    job: TrialJob, trials: Sequence[tuple[int, TrialConfig]], workers: Workers
) -> Generator[Attempt, None, None]:
    """Yields the attempts as they end, in any order; closing the iterator stops the work."""
    answers = workers.run_all(job, trials)
    try:
        for answer in answers:
            if isinstance(answer, Lost):
                yield job.crashed(answer.task, answer.wall_s, answer.remark, answer.remark)
            else:
                yield answer
    finally:
        answers.close()
