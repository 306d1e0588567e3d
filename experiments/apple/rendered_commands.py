"""The commands `beltgrasp apple replay` and `beltgrasp apple approach`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import arg

from experiments.study.arguments import seed_range, split_names, worker_count
from experiments.study.exits import CRASH_EXIT, tell_interrupted

if TYPE_CHECKING:
    from experiments.apple.row_file import RowFile
    from experiments.apple.study import Study

# Everything heavy is imported inside the commands, so that --help answers at once.

_ASPECTS = (0.85, 0.92, 0.95)


@dataclass(frozen=True)
class Replay:
    """Takes the images of the paper's tables again: `beltgrasp apple replay --out out/replay`."""

    out: Annotated[Path, arg(metavar="DIR")]
    """Results folder; the same command again resumes, other seeds are added."""
    tables: tuple[int, ...] = (1, 2)
    """Tables of which the camera poses are taken."""
    aspects: tuple[float, ...] = _ASPECTS
    """Height over diameter of the fruits."""
    seeds: Annotated[int, arg(metavar="N")] = 30
    """Fruits, lights and leaves with the seeds FIRST to FIRST + N - 1."""
    first_seed: Annotated[int, arg(metavar="FIRST")] = 0
    """The lowest seed."""
    workers: Annotated[int | None, arg(metavar="N")] = None
    """Worker processes; one for each processor if not given. The results do not depend on it."""

    def run(self) -> int:
        """Exit code 0, or 1 if a world failed."""
        from experiments.apple.replay import ReplayJob, replay_file, replay_order, replay_rows
        from experiments.apple.study import Study

        jobs = [
            ReplayJob(table, aspect, seed)
            for table in self.tables
            for aspect in self.aspects
            for seed in seed_range(self.seeds, self.first_seed)
        ]
        study = Study("replay", _settings(), replay_rows, lambda job: job.key)
        return _run(study, jobs, replay_file(self.out), replay_order, self.workers)


@dataclass(frozen=True)
class Approach:
    """Lets the arm approach fruits and tell their attitude: `beltgrasp apple approach`."""

    out: Annotated[Path | None, arg(metavar="DIR")] = None
    """Results folder; the same command again resumes, other worlds are added."""
    classes: Annotated[tuple[str, ...], arg(metavar="NAMES")] = (
        "visible",
        "hidden",
        "visible-leaves",
        "hidden-leaves",
    )
    """Any of visible, hidden, visible-leaves and hidden-leaves: the calyx, and leaves in front."""
    aspects: tuple[float, ...] = _ASPECTS
    """Height over diameter of the fruits."""
    views: Annotated[tuple[str, ...], arg(metavar="NAMES")] = ("arc",)
    """How the camera's places are chosen: arc, next-best, or both, compared in the same worlds."""
    seeds: Annotated[int, arg(metavar="N")] = 30
    """Worlds with the seeds FIRST to FIRST + N - 1."""
    first_seed: Annotated[int, arg(metavar="FIRST")] = 0
    """The lowest seed."""
    video: Annotated[Path | None, arg(metavar="FILE")] = None
    """Films the first of these worlds instead: the camera's view with outline, axis and its
    uncertainty, beside the arm."""
    workers: Annotated[int | None, arg(metavar="N")] = None
    """Worker processes; one for each processor if not given. The results do not depend on it."""

    def run(self) -> int:
        """Exit code 0, or 1 if a world failed."""
        from experiments.apple.approach import (
            ApproachJob,
            approach_file,
            approach_order,
            approach_rows,
        )
        from experiments.apple.study import Study
        from experiments.apple.worlds import WorldId

        jobs = [
            ApproachJob(WorldId(fruit_class, aspect, seed), views)
            for fruit_class in split_names(self.classes)
            for aspect in self.aspects
            for seed in seed_range(self.seeds, self.first_seed)
            for views in split_names(self.views)
        ]
        if not jobs:
            raise ValueError("classes, aspects and views must each name one at least")
        if self.video is not None:
            from experiments.apple.film import film_approach

            film_approach(jobs[0], self.video)
            print(f"video: {self.video}")
            return 0
        if self.out is None:
            raise ValueError("--out DIR or --video FILE must be given")
        study = Study("approach", _settings(), approach_rows, lambda job: job.key)
        return _run(study, jobs, approach_file(self.out), approach_order, self.workers)


def _settings() -> dict[str, Any]:
    from dataclasses import asdict

    from experiments.apple.methods import METHODS
    from experiments.apple.observer import MASKS
    from sim.apple.eye_in_hand import PoseNoise

    return {"methods": list(METHODS), "masks": list(MASKS), "pose_noise": asdict(PoseNoise())}


def _run(
    study: Study[Any, Any],
    jobs: list[Any],
    rows: RowFile[Any],
    order: Callable[[tuple[object, ...]], Any],
    workers: int | None,
) -> int:
    from experiments.apple.report import write_report
    from experiments.apple.study import run_study
    from experiments.belt.rendering import gl_renderer
    from experiments.study.processes import LocalWorkers

    gl_renderer()
    folder = rows.path.parent
    try:
        failures = run_study(study, jobs, rows, order, LocalWorkers(worker_count(workers)))
    except KeyboardInterrupt:
        return tell_interrupted(folder)
    if rows.path.exists():
        write_report(folder).show()
        print(f"rows: {rows.path}")
    return CRASH_EXIT if failures else 0
