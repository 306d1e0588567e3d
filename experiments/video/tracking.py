"""Runs one job: the tracker from each start of the protocol to the end of the sequence.

`DIR/boxes/PROTOCOL/TRACKER/SEED/SEQUENCE.csv` has a line `run,frame,x,y,w,h` for each frame of each
run, the frame counted from 1, x and y 1-based as in the ground truth. `DIR/affine/...` has the
fields of `AffineRow` for each frame after a run's first. A file is there when its job is done, and
never half.
"""

from __future__ import annotations

import traceback
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path

import numpy as np

from experiments import seeding
from experiments.study import records
from experiments.video.affine_scores import AffineReferee, AffineRow
from experiments.video.contestants import get_contestant
from experiments.video.images import SequenceError
from experiments.video.jobs import Job
from experiments.video.protocols import Run, runs_of
from experiments.video.sequences import VideoSequence, load_sequence
from tracker.box_tracker import BoxEstimate, BoxTracker

BOXES_HEADER = "run,frame,x,y,w,h\n"
_ONE = np.array([1.0, 1.0, 0.0, 0.0])
"""From pixels counted from 0 to the benchmark's, counted from 1."""


@dataclass(frozen=True)
class Done:
    """What became of a job."""

    job: Job
    complaint: str | None = None
    """One line that says why it failed."""


@dataclass(frozen=True)
class Tracking:
    """The work of a worker process: answers a job with its files."""

    out: Path

    def __call__(self, job: Job) -> Done:
        """Runs the job and writes its files; what goes wrong becomes one line."""
        try:
            sequence = load_sequence(job.sequence, job.ground_truth)
            lanes = track(job, sequence)
        except SequenceError as error:
            return Done(job, f"{job.sequence}: {error}")
        except Exception as error:
            path = job.error_path(self.out)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(traceback.format_exc(), encoding="utf-8")
            cause = f"{type(error).__name__}: {error}"
            return Done(job, f"{job.sequence}: {job.tracker} crashed ({cause}); see {path}")
        if sequence.affine is not None:
            header = records.csv_line(field.name for field in fields(AffineRow))
            _write(job.affine_path(self.out), header, [lane.affine for lane in lanes])
        _write(job.boxes_path(self.out), BOXES_HEADER, [lane.boxes for lane in lanes])
        return Done(job)


def track(job: Job, sequence: VideoSequence) -> list[Lane]:
    """All runs of a job side by side, so that each image is read once."""
    lanes = [Lane.of(job, sequence, run) for run in runs_of(job.protocol, sequence)]
    for index in range(min(lane.run.first for lane in lanes), len(sequence)):
        image = sequence.image(index)
        for lane in lanes:
            if index == lane.run.first:
                lane.start(image, sequence, job.tracker)
            elif index > lane.run.first:
                lane.step(image, index)
    return lanes


@dataclass
class Lane:
    """One run, and the lines that it leaves."""

    run: Run
    tracker: BoxTracker
    referee: AffineReferee | None
    boxes: list[str] = field(default_factory=list[str])
    affine: list[str] = field(default_factory=list[str])

    @classmethod
    def of(cls, job: Job, sequence: VideoSequence, run: Run) -> Lane:
        """A run with a fresh tracker, its random draws addressed by seed, sequence and run."""
        place = f"{job.protocol}/{sequence.name}/{run.name}"
        rng = seeding.generator(job.seed, seeding.Stream.VIDEO, place)
        truth, box = sequence.affine, run.box - _ONE
        referee = None if truth is None else AffineReferee(truth, run.name, run.first, box)
        return cls(run, get_contestant(job.tracker).make(rng), referee)

    def start(self, image: np.ndarray, sequence: VideoSequence, tracker: str) -> None:
        """Gives the tracker its box; SequenceError where it sees nothing to track there."""
        try:
            self.tracker.start(image, self.run.box - _ONE)
        except ValueError as error:
            line = sequence.line(self.run.first)
            raise SequenceError(f"{line}: {tracker} refuses to start: {error}") from None
        self._note_box(self.run.first, self.run.box)

    def step(self, image: np.ndarray, index: int) -> None:
        """Shows the tracker the image of that index."""
        estimate: BoxEstimate = self.tracker.update(image)
        self._note_box(index, estimate.box + _ONE)
        if self.referee is not None:
            row = self.referee.row(index, estimate)
            self.affine.append(records.csv_line(getattr(row, f.name) for f in fields(row)))

    def _note_box(self, index: int, box: np.ndarray) -> None:
        numbers = ",".join(f"{value + 0.0:.4f}" for value in box)
        self.boxes.append(f"{self.run.name},{index + 1},{numbers}\n")


def _write(path: Path, header: str, lines: Sequence[Sequence[str]]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    records.write_whole(path, header + "".join("".join(run) for run in lines))
