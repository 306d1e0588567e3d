"""The commands `beltgrasp trial`, `sweep` and `view`: one attempt, many, and a look at the cell."""

import json as json_format
import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from experiments.belt.config import TrialConfig
from experiments.study.command import CRASH_EXIT, Plan, StudyCommand, seed_list, split_names

# Everything heavy is imported inside the commands, so that --help answers at once.


@dataclass(frozen=True)
class Trial:
    """Runs one attempt and prints its row: `beltgrasp trial --tracker igpf --speed-mps 0.25`."""

    config: Annotated[TrialConfig, arg(name="")]
    out: Annotated[Path | None, arg(metavar="DIR")] = None
    """Also keeps the row in this results folder, with those of other trials."""
    video: Annotated[Path | None, arg(metavar="FILE")] = None
    """Writes an MP4: the camera's view with warp, particles and phase, beside the cell."""
    json: bool = False
    """Prints the row as one JSON object instead of a summary."""

    def run(self) -> int:
        """Exit code 0, or 1 for an attempt that crashed; a failed grasp is no crash."""
        from experiments.belt.analysis.summary import summary_lines
        from experiments.belt.study import SINGLE, SUBJECT, SweepTrial, get_study, selection_of
        from experiments.study.processes import limit_threads
        from experiments.study.rendering import gl_renderer
        from experiments.study.rows import to_json
        from experiments.study.run import Work, keep

        limit_threads()
        study, job = get_study(f"{SUBJECT}/{SINGLE}"), SweepTrial(SINGLE, self.config, self.video)
        study.settings(job)  # complains of unknown names
        gl_renderer()
        if self.video is not None:
            self.video.parent.mkdir(parents=True, exist_ok=True)
        ((_, result),) = Work(study)((job,))
        if self.out is not None:
            keep(study, selection_of([self.config], [self.config.seed]), self.out, job, result)
        if result.error is not None:
            print(result.error.rstrip(), file=sys.stderr)
        (row,) = result.rows
        if self.json:
            print(json_format.dumps(to_json(row)))
        else:
            print("\n".join(summary_lines(self.config, row, result.timings)))
            if self.video is not None and result.error is None:
                print(f"video: {self.video}")
        return 0 if result.error is None else CRASH_EXIT


@dataclass(frozen=True, kw_only=True)
class Sweep(StudyCommand):
    """Runs a preset into a folder; the same command again resumes: `beltgrasp sweep demo`."""

    preset: Annotated[Positional[str], arg(metavar="PRESET")]
    """Name of the preset; `beltgrasp list` names them."""
    trackers: Annotated[tuple[str, ...], arg(metavar="NAMES")] = ()
    """Only these, with commas or spaces between; one that the preset lacks, also an import path,
    takes the cells of its first tracker."""

    def plan(self) -> Plan:
        """The preset's cells and seeds, or those that the flags leave of them."""
        from experiments.belt.presets import PRESETS
        from experiments.belt.study import SUBJECT, get_study, selection_of
        from tracker.checks import require_known

        require_known("preset", self.preset, PRESETS)
        preset = PRESETS[self.preset]
        if self.seeds is not None or self.first_seed:
            count = len(preset.seeds) if self.seeds is None else self.seeds
            preset = preset.restricted(seeds=seed_list(count, self.first_seed))
        preset = preset.restricted(split_names(self.trackers))
        study = get_study(f"{SUBJECT}/{preset.name}")
        return Plan(study, selection_of(preset.cells, preset.seeds))


@dataclass(frozen=True)
class View:
    """Opens MuJoCo's interactive viewer on the scene of a trial; needs a display."""

    config: Annotated[TrialConfig, arg(name="")]

    def run(self) -> int:
        """Exit code 0 when the window is closed."""
        if sys.platform.startswith("linux") and not (
            os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
        ):
            raise OSError("view needs a display, and neither DISPLAY nor WAYLAND_DISPLAY is set")
        from experiments.belt.study import SINGLE, SweepTrial, trial_settings
        from experiments.belt.viewer import show

        trial_settings(SweepTrial(SINGLE, self.config))  # complains of unknown names
        show(self.config)
        return 0
