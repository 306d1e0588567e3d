"""One attempt: from a configuration to a row."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from experiments import metrics
from experiments.cell import make_cell
from experiments.config import TrialConfig, TrialResult, TrialTimings
from experiments.loop import Loop
from experiments.manifest import provenance
from experiments.perception import CONTROL_ARMS
from experiments.video import VideoRecorder

_CONFIG_COLUMNS = (
    "tracker embodiment camera condition object motion predictor speed_mps delay_s seed".split()
)


def run_trial(
    config: TrialConfig, video_path: Path | None = None, *, preset: str = "trial"
) -> tuple[TrialResult, TrialTimings]:
    """Runs one attempt.

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
    shared = {name: getattr(config, name) for name in _CONFIG_COLUMNS}
    origin = {"preset": preset, "gl_renderer": cell.task.gl_renderer} | provenance()
    columns: dict[str, Any] = {"trial_id": config.trial_id, **shared, **measured, **origin}
    return TrialResult(**columns), loop.timings()
