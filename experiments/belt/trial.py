"""One attempt: from a configuration to a row."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from experiments.belt import metrics
from experiments.belt.cell import make_cell
from experiments.belt.config import TrialConfig, TrialResult
from experiments.belt.curves import CURVES, ErrorCurve
from experiments.belt.loop import Loop
from experiments.belt.perception import CONTROL_ARMS
from experiments.belt.recorder import VideoRecorder
from experiments.belt.study import SINGLE, SweepTrial
from experiments.study.provenance import provenance
from experiments.study.study import Result


def run_trials(jobs: Sequence[SweepTrial]) -> list[Result[TrialResult]]:
    """Runs attempts of sweeps, one after the other."""
    return [run_trial(job.config, job.video_path, preset=job.preset) for job in jobs]


def film_trial(job: SweepTrial, path: Path) -> str:
    """Runs the attempt again with a recorder; returns how it ended."""
    return run_trial(job.config, path, preset=job.preset).rows[0].outcome


def run_trial(
    config: TrialConfig, video_path: Path | None = None, *, preset: str = SINGLE
) -> Result[TrialResult]:
    """Runs one attempt; returns its row, what it cost, and its error curve.

    Args:
        config: Everything that determines the attempt.
        video_path: Where to write a video of it, if anywhere.
        preset: Name of the sweep it belongs to, for the row.
    """
    has_camera = video_path is not None or config.tracker not in CONTROL_ARMS
    cell = make_cell(config, has_camera=has_camera)
    with VideoRecorder(video_path, config) as video:
        loop = Loop(config, cell)
        while loop.is_running:
            loop.step()
            video.add(loop)
    measured = metrics.score(config, loop.trace, loop.record, loop.entered_view_s)
    origin = {"preset": preset, "gl_renderer": cell.task.gl_renderer} | provenance()
    columns: dict[str, Any] = {"trial_id": config.trial_id, **asdict(config), **measured, **origin}
    curve = ErrorCurve.of(loop.trace, loop.entered_view_s if loop.has_entered_view else None)
    curves = {CURVES: curve.to_csv(config.trial_id)}
    return Result((TrialResult(**columns),), loop.timings(), curves)
