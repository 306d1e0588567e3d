"""Runs a preset: every cell at every seed, resumable, with the same bytes whoever runs it."""

from __future__ import annotations

import contextlib
import sys
from collections import Counter
from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path

from experiments.belt.config import TrialResult, TrialTimings
from experiments.belt.films import Scene, VideoChoice, make_films
from experiments.belt.presets import Preset
from experiments.study import manifest, records
from experiments.study.processes import Workers
from experiments.study.progress import progress_bar
from experiments.study.results_folder import VIDEOS, ResultsFolder, exclusive
from experiments.study.workers import RUN_TRIAL, TrialJob, run_all

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
    video_count: int
    """Videos that were asked for and are there."""
    lost_video_count: int
    """Videos that could not be made."""


def run_sweep(
    preset: Preset,
    out_dir: Path,
    workers: Workers,
    video: VideoChoice = "none",
    run_trial: str = RUN_TRIAL,
) -> SweepSummary:
    """Runs the trials of `preset` that `out_dir` lacks, and appends their rows as they end.

    Args:
        preset: What to run: a whole sweep or a shard of one.
        out_dir: Results folder: new, empty, or an unfinished sweep of the same preset.
        workers: Who runs the trials; the rows do not depend on it.
        video: Of which trials videos are made, when all have their rows.
        run_trial: Import path `module:function` of the function that runs one trial.
    """
    with exclusive(out_dir):
        manifest.open_manifest(out_dir, preset, workers.count)
        manifest.warn_of_mixed_code(out_dir)
        folder = ResultsFolder(out_dir, [trial.trial_id for trial in preset.trials])
        _announce(preset, folder, workers.count)
        job = TrialJob(preset.name, manifest.provenance(), run_trial)
        with _telling_what_is_kept(preset, folder, out_dir):
            _run_missing(job, preset, folder, workers)
            results = records.read_rows(folder.trials_path, TrialResult)
            renderers = [row.gl_renderer for row in results if row.gl_renderer]
            manifest.close_manifest(out_dir, renderers)
            scenes = map(Scene, preset.trials, [row.outcome for row in results])
            wanted = [scene for scene in scenes if scene.is_wanted(video)]
            video_count, lost_video_count = make_films(job, wanted, out_dir / VIDEOS, workers)
    return SweepSummary(
        trials_path=folder.trials_path,
        trial_count=len(results),
        success_count=sum(row.success for row in results),
        error_count=sum(row.outcome == "error" for row in results),
        video_count=video_count,
        lost_video_count=lost_video_count,
    )


@contextlib.contextmanager
def _telling_what_is_kept(
    preset: Preset, folder: ResultsFolder, out_dir: Path
) -> Generator[None, None, None]:
    """Ctrl-C, a full disk and a lost cluster say that nothing finished is lost."""
    try:
        yield
    except (KeyboardInterrupt, OSError) as error:
        kept = len(preset.trials) - len(folder.missing)
        text = f"{kept} of {len(preset.trials)} trials are kept in {out_dir}"
        if isinstance(error, OSError):
            raise OSError(f"{error}; {text}, and the same command resumes") from error
        raise SweepInterrupted(f"stopped; {text}") from None


def _announce(preset: Preset, folder: ResultsFolder, worker_count: int) -> None:
    """Says what is about to run and how long that may take."""
    timings = records.read_rows(folder.timings_path, TrialTimings)
    trial_s = sum(row.wall_s for row in timings) / len(timings) if timings else ASSUMED_TRIAL_S
    missing = len(folder.missing)
    done = len(preset.trials) - missing
    already = f", {done} of them done" if done else ""
    duration = _in_words(trial_s * missing / max(1, min(worker_count, missing)))
    source = "as timed here" if timings else "assumed"
    print(
        f"{preset.name}: {describe(preset)}{already}; "
        f"about {duration} with {worker_count or 'no'} worker{'s' * (worker_count != 1)}"
        f"{' yet' * (worker_count == 0)} ({trial_s:.2g} s a trial, {source})",
        file=sys.stderr,
        flush=True,
    )


def describe(preset: Preset) -> str:
    """Size of a preset in words."""
    cells, seeds, trials = len(preset.cells), len(preset.seeds), len(preset.trials)
    size = f"{cells} cells x {seeds} seed{'s' * (seeds > 1)}"
    if preset.shard is None:
        return f"{size} = {trials} trials"
    return f"shard {preset.shard} of {size}, {trials} of {len(preset.all_trials)} trials"


def _in_words(duration_s: float) -> str:
    """A duration to two digits, in the unit that suits it."""
    for unit, length_s in (("h", 3600.0), ("min", 60.0)):
        if duration_s >= 1.5 * length_s:
            return f"{duration_s / length_s:.{1 if duration_s < 10.0 * length_s else 0}f} {unit}"
    return f"{duration_s:.0f} s"


def _run_missing(job: TrialJob, preset: Preset, folder: ResultsFolder, workers: Workers) -> None:
    missing = [(index, preset.trials[index]) for index in folder.missing]
    attempts = run_all(job, missing, workers)
    done = len(preset.trials) - len(missing)
    bar = progress_bar(preset.name, "trial", len(preset.trials), done)
    with contextlib.closing(attempts), bar:
        counts = Counter(row.outcome for row in records.read_rows(folder.trials_path, TrialResult))
        for attempt in attempts:
            folder.add(attempt)
            counts[attempt.result.outcome] += 1
            bar.set_postfix_str(_running_counts(counts), refresh=False)
            bar.update()


def _running_counts(counts: Counter[str]) -> str:
    """Successes so far and, if any, crashes."""
    text = f"success {counts['success']}/{counts.total()}"
    return text + (f", errors {counts['error']}" if counts["error"] else "")
