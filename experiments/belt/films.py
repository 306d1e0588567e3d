"""Videos of a sweep's trials, made when all have their rows: each is run again with the recorder.

The same trial gives the same attempt, so that nothing need be recorded before it is known how it
ends. A video is there when it is whole, so that a sweep that was stopped makes those that lack.
"""

from __future__ import annotations

import contextlib
import re
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias

from experiments.belt.config import Outcome, TrialConfig
from experiments.study import records, workers
from experiments.study.processes import Lost, Workers
from experiments.study.progress import progress_bar
from experiments.study.workers import TrialJob

VideoChoice: TypeAlias = Literal["none", "failures", "all"]


@dataclass(frozen=True)
class Scene:
    """A trial to be filmed, and how it ended when its row was written."""

    config: TrialConfig
    outcome: Outcome

    @property
    def file_name(self) -> str:
        """PASS or FAIL and outcome, tracker, speed, condition and seed; the id tells the rest."""
        verdict = "PASS" if self.outcome == "success" else "FAIL"
        tracker = re.sub(r"[^\w.-]", ".", self.config.tracker)
        return (
            f"{verdict}_{self.outcome}_{tracker}_{self.config.speed_mps:.2f}mps_"
            f"{self.config.condition}_seed{self.config.seed}_{self.config.trial_id}.mp4"
        )

    def is_wanted(self, choice: VideoChoice) -> bool:
        """Whether its video is asked for; a trial that crashed has a traceback instead."""
        if self.outcome == "error":
            return False
        return choice == "all" or (choice == "failures" and self.outcome != "success")


@dataclass(frozen=True)
class Film:
    """What became of a scene: a video, or one line that says why there is none."""

    scene: Scene
    video: bytes = b""
    complaint: str | None = None


@dataclass(frozen=True)
class FilmJob:
    """The work of a worker: films a scene. The video travels, as workers may have other disks."""

    job: TrialJob

    def __call__(self, scene: Scene) -> Film:
        """The film of the scene, if it ends as it did before."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / scene.file_name
            result = workers.attempt(self.job, 0, scene.config, path).result
            if result.outcome != scene.outcome:
                detail = f" ({' '.join(result.detail.split())})" if result.detail else ""
                return Film(scene, complaint=f"ended in {result.outcome}{detail} when filmed")
            return Film(scene, path.read_bytes())


def make_films(
    job: TrialJob, scenes: Sequence[Scene], folder: Path, crew: Workers
) -> tuple[int, int]:
    """Makes the videos that the folder lacks; the numbers of those there and of complaints."""
    missing = [scene for scene in scenes if not (folder / scene.file_name).exists()]
    if not missing:
        return len(scenes), 0
    folder.mkdir(exist_ok=True)
    complaint_count = 0
    films = crew.run_all(FilmJob(job), missing)
    bar = progress_bar("videos", "video", len(scenes), len(scenes) - len(missing))
    with contextlib.closing(films), bar:
        for answer in films:
            film = answer
            if isinstance(film, Lost):
                film = Film(film.task, complaint=film.remark)
            if film.complaint is None:
                records.write_whole(folder / film.scene.file_name, film.video)
            else:
                complaint_count += 1
                line = f"beltgrasp: error: {film.scene.file_name}: {film.complaint}"
                bar.write(line, file=sys.stderr)
            bar.update()
    return len(scenes) - complaint_count, complaint_count
