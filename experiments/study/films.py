"""Videos of jobs, made when all have their rows: each job is run again with a recorder.

The same job gives the same result, so that nothing need be recorded before it is known how it
ends. A video is there when it is whole, so that a run that was stopped makes those that lack.
"""

import contextlib
import re
import sys
import tempfile
import traceback
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, Literal, TypeAlias

from tqdm import tqdm

from experiments.study.files import write_whole
from experiments.study.folder import VIDEOS, ResultsFolder
from experiments.study.processes import Lost, Workers
from experiments.study.progress import progress_bar
from experiments.study.study import Job, Row, Study, load

VideoChoice: TypeAlias = Literal["none", "failures", "all"]


@dataclass(frozen=True)
class Scene(Generic[Job]):
    """A job to be filmed, and how it ended when its row was written."""

    job: Job
    outcome: str
    file_name: str


@dataclass(frozen=True)
class Film(Generic[Job]):
    """What became of a scene: a video, or one line that says why there is none."""

    scene: Scene[Job]
    video: bytes = b""
    complaint: str | None = None


@dataclass(frozen=True)
class _Filming(Generic[Job, Row]):
    """The work of a worker: films a scene. The video travels, as workers may have other disks."""

    study: Study[Job, Row]

    def __call__(self, scene: Scene[Job]) -> Film[Job]:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "film.mp4"
            try:
                outcome = load(self.study.film)(scene.job, path)
            except Exception as error:
                traceback.print_exc()
                return Film(scene, complaint=f"{type(error).__name__}: {error}")
            if outcome is not None and outcome != scene.outcome:
                return Film(scene, complaint=f"ended in {outcome} when filmed")
            return Film(scene, path.read_bytes())


def make_films(
    study: Study[Job, Row],
    folder: ResultsFolder[Job, Row],
    jobs: Sequence[Job],
    choice: VideoChoice,
    workers: Workers,
) -> tuple[int, int]:
    """Makes the videos that the folder lacks; the numbers of those there and of complaints."""
    if choice == "none":
        return 0, 0
    videos = folder.rows_path.parent / VIDEOS
    scenes = [scene for job in jobs if (scene := _scene(study, folder, job, choice)) is not None]
    missing = [scene for scene in scenes if not (videos / scene.file_name).exists()]
    if not missing:
        return len(scenes), 0
    videos.mkdir(exist_ok=True)
    complaint_count = 0
    films = workers.run_all(_Filming(study), missing)
    bar = progress_bar("videos", "video", len(scenes), len(scenes) - len(missing))
    with contextlib.closing(films), bar:
        for answer in films:
            film = (
                Film(answer.task, complaint=answer.remark) if isinstance(answer, Lost) else answer
            )
            if film.complaint is None:
                write_whole(videos / film.scene.file_name, film.video)
            else:
                complaint_count += 1
                line = f"beltgrasp: error: {film.scene.file_name}: {film.complaint}"
                tqdm.write(" ".join(line.split()), file=sys.stderr)
            bar.update()
    return len(scenes) - complaint_count, complaint_count


def _scene(
    study: Study[Job, Row], folder: ResultsFolder[Job, Row], job: Job, choice: VideoChoice
) -> Scene[Job] | None:
    """The scene of a job, if it is asked for; a job that crashed has a traceback instead."""
    found: list[Any] = folder.rows_of(job)
    outcome, is_failure = found[0].outcome, study.is_failure(found)
    if outcome == "error" or (choice == "failures" and not is_failure):
        return None
    title = re.sub(r"[^\w.+-]+", "_", study.title(job))
    verdict = "FAIL" if is_failure else "PASS"
    name = f"{verdict}_{outcome}_{title}_{'_'.join(study.key_of(job))}.mp4"
    return Scene(job, outcome, re.sub(r"[^\w.+-]", ".", name))
