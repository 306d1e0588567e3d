"""Runs a preset: every cell at every seed, resumable, with the same bytes for any worker count."""

from __future__ import annotations

import contextlib
import os
import sys
from collections import Counter
from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tqdm import tqdm

from experiments import manifest, records
from experiments.config import TrialResult, TrialTimings
from experiments.presets import Preset
from experiments.results_folder import ResultsFolder, exclusive
from experiments.workers import RUN_TRIAL, TrialJob, run_all

ASSUMED_TRIAL_S = 6.0
"""Processor time of one trial, before any has been measured [s]."""


class SweepInterrupted(Exception):
    """Ctrl-C ended the sweep; the finished trials are kept."""


@dataclass(frozen=True)
class SweepSummary:
    """What a complete sweep left behind."""

    trials_path: Path
    trial_count: int
    success_count: int
    error_count: int


def default_worker_count() -> int:
    """One worker for each processor this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def run_sweep(
    preset: Preset, out_dir: Path, workers: int, run_trial: str = RUN_TRIAL
) -> SweepSummary:
    """Runs the trials of `preset` that `out_dir` lacks, and appends their rows as they end.

    Args:
        preset: What to run.
        out_dir: Results folder: new, empty, or an unfinished sweep of the same preset.
        workers: Number of worker processes; the rows do not depend on it.
        run_trial: Import path `module:function` of the function that runs one trial.
    """
    if workers < 1:
        raise ValueError(f"workers must be 1 or greater, got {workers}")
    with exclusive(out_dir):
        manifest.open_manifest(out_dir, preset, workers)
        manifest.warn_of_mixed_code(out_dir)
        folder = ResultsFolder(out_dir, [trial.trial_id for trial in preset.trials])
        _announce(preset, folder, workers)
        try:
            _run_missing(preset, folder, workers, run_trial)
        except KeyboardInterrupt:
            kept = len(preset.trials) - len(folder.missing)
            raise SweepInterrupted(
                f"stopped; {kept} of {len(preset.trials)} trials are kept in {out_dir}"
            ) from None
        results = records.read_rows(folder.trials_path, TrialResult)
        manifest.close_manifest(out_dir, [row.gl_renderer for row in results if row.gl_renderer])
    return SweepSummary(
        trials_path=folder.trials_path,
        trial_count=len(results),
        success_count=sum(row.success for row in results),
        error_count=sum(row.outcome == "error" for row in results),
    )


def describe(preset: Preset) -> str:
    """Size of a preset in words."""
    cells, seeds, trials = len(preset.cells), len(preset.seeds), len(preset.trials)
    return f"{cells} cells x {seeds} seed{'s' * (seeds > 1)} = {trials} trials"


def _announce(preset: Preset, folder: ResultsFolder, workers: int) -> None:
    """Says what is about to run and how long that may take."""
    timings = records.read_rows(folder.timings_path, TrialTimings)
    mean_s = sum(row.wall_s for row in timings) / len(timings) if timings else ASSUMED_TRIAL_S
    missing = len(folder.missing)
    expected = tqdm.format_interval(mean_s * missing / min(workers, max(missing, 1)))
    done = len(preset.trials) - missing
    already = f", {done} of them done" if done else ""
    print(
        f"{preset.name}: {describe(preset)}{already}; "
        f"about {expected} (min:s) with {workers} worker{'s' * (workers > 1)}",
        file=sys.stderr,
        flush=True,
    )


def _run_missing(preset: Preset, folder: ResultsFolder, workers: int, run_trial: str) -> None:
    job = TrialJob(preset.name, manifest.provenance(), run_trial)
    missing = [(index, preset.trials[index]) for index in folder.missing]
    attempts = run_all(job, missing, workers)
    with contextlib.closing(attempts), _progress_bar(preset, folder) as bar:
        counts = Counter(row.outcome for row in records.read_rows(folder.trials_path, TrialResult))
        for attempt in attempts:
            folder.add(attempt)
            counts[attempt.result.outcome] += 1
            bar.set_postfix_str(_running_counts(counts), refresh=False)
            bar.update()


@contextlib.contextmanager
def _progress_bar(preset: Preset, folder: ResultsFolder) -> Generator[tqdm[Any], None, None]:
    """A bar with the time left; in a log file a line now and then instead of a live one."""
    bar: tqdm[Any] = tqdm(
        total=len(preset.trials),
        initial=len(preset.trials) - len(folder.missing),
        desc=preset.name,
        unit="trial",
        smoothing=0.1,
        file=sys.stderr,
        mininterval=0.5 if sys.stderr.isatty() else 15.0,
    )
    with bar:
        yield bar


def _running_counts(counts: Counter[str]) -> str:
    """Successes so far and, if any, crashes."""
    text = f"success {counts['success']}/{counts.total()}"
    return text + (f", errors {counts['error']}" if counts["error"] else "")
