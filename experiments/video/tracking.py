"""Runs one job: the tracker from each start of the protocol to the end of the sequence.

`boxes/PROTOCOL/TRACKER/SEED/SEQUENCE.csv` has a line `run,frame,x,y,w,h` for each frame of each
run, the frame counted from 1, x and y 1-based as in the ground truth.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

import numpy as np

from experiments import seeding
from experiments.report.table import csv_line
from experiments.study.provenance import code_version
from experiments.study.rows import row_line
from experiments.study.study import Result
from experiments.video.affine_scores import AffineReferee
from experiments.video.job import AFFINE, HITS, VideoJob, VideoRow
from experiments.video.protocols import Run, runs_of
from experiments.video.scores import sequence_curves
from experiments.video.sequences import SequenceError, VideoSequence, find_sequences, load_sequence
from experiments.video.trackers import get_video_tracker
from tracker.box_tracker import BoxEstimate, BoxTracker
from tracker.video.particle_box_tracker import ParticleBoxTracker

BOXES_HEADER = "run,frame,x,y,w,h\n"
FROM_ONE = np.array([1.0, 1.0, 0.0, 0.0])
"""From pixels counted from 0 to the benchmark's, counted from 1."""


def run_jobs(jobs: Sequence[VideoJob]) -> list[Result[VideoRow]]:
    """Runs trackers on sequences, one after the other."""
    return [run_job(job) for job in jobs]


def run_job(job: VideoJob) -> Result[VideoRow]:
    """The scores, boxes and affine errors of one tracker with one seed on one sequence."""
    sequence = load_job_sequence(job)
    passes = track(job, sequence)
    truths = [sequence.boxes[one.run.first :] for one in passes]
    curves = sequence_curves([np.array(one.boxes) for one in passes], truths)
    frame_count = sum(map(len, truths))
    row = VideoRow(
        protocol=job.protocol,
        sequence=job.sequence,
        tracker=job.tracker,
        seed=job.seed,
        outcome="done",
        run_count=len(passes),
        frame_count=frame_count,
        distance_precision=curves.distance_precision,
        overlap_score=curves.overlap_score,
        attributes=" ".join(sequence.attributes),
        commit=str(code_version()),
    )
    key = [job.protocol, job.sequence, job.tracker, job.seed]
    named = csv_line(key).rstrip("\n")
    boxes = "".join(line for one in passes for line in one.box_lines)
    return Result(
        rows=(row,),
        curves={
            HITS: csv_line([*key, *curves.hits(frame_count)]),
            AFFINE: "".join(f"{named},{line}" for one in passes for line in one.affine_lines),
        },
        files={job.boxes_path: BOXES_HEADER + boxes},
    )


def load_job_sequence(job: VideoJob) -> VideoSequence:
    """The sequence of a job; SequenceError where its folder is missing or faulty."""
    found = find_sequences(Path(job.root))
    if job.sequence not in found:
        raise SequenceError(f"{job.root} holds no sequence {job.sequence!r}")
    return load_sequence(job.sequence, found[job.sequence])


@dataclass
class Pass:
    """One run of a tracker, and what it leaves."""

    run: Run
    tracker: BoxTracker
    referee: AffineReferee | None
    boxes: list[list[float]] = field(default_factory=list[list[float]])
    """x, y, w, h of each frame, x and y 1-based, to 0.0001 px."""
    box_lines: list[str] = field(default_factory=list[str])
    affine_lines: list[str] = field(default_factory=list[str])

    @classmethod
    def of(cls, job: VideoJob, sequence: VideoSequence, run: Run) -> Self:
        """A run with a fresh tracker, its random draws addressed by seed, sequence and run."""
        place = f"{job.protocol}/{sequence.name}/{run.name}"
        rng = seeding.generator(job.seed, seeding.Stream.VIDEO, place)
        truth, box = sequence.affine, run.box - FROM_ONE
        tracker = get_video_tracker(job.tracker).make(rng)
        referee = None if truth is None else AffineReferee(truth, run.name, run.first, box)
        if referee is not None and isinstance(tracker, ParticleBoxTracker):
            tracker.collect_resamplings(referee.note_resampling)
        return cls(run, tracker, referee)

    def start(self, image: np.ndarray, sequence: VideoSequence, tracker: str) -> None:
        """Gives the tracker its box; SequenceError where it sees nothing to track there."""
        try:
            self.tracker.start(image, self.run.box - FROM_ONE)
        except ValueError as error:
            line = sequence.line(self.run.first)
            raise SequenceError(f"{line}: {tracker} refuses to start: {error}") from None
        self._note_box(self.run.first, self.run.box)

    def step(self, image: np.ndarray, index: int) -> None:
        """Shows the tracker the image of that index."""
        estimate: BoxEstimate = self.tracker.update(image)
        self._note_box(index, estimate.box + FROM_ONE)
        if self.referee is not None:
            self.affine_lines.append(row_line(self.referee.row(index, estimate)))

    def _note_box(self, index: int, box: np.ndarray) -> None:
        numbers = [f"{value + 0.0:.4f}" for value in box]
        self.boxes.append([float(number) for number in numbers])
        self.box_lines.append(f"{self.run.name},{index + 1},{','.join(numbers)}\n")


def track(job: VideoJob, sequence: VideoSequence) -> list[Pass]:
    """All runs of a job side by side, so that each image is read once."""
    passes = [Pass.of(job, sequence, run) for run in runs_of(job.protocol, sequence)]
    for index in range(min(one.run.first for one in passes), len(sequence)):
        image = sequence.image(index)
        for one in passes:
            if index == one.run.first:
                one.start(image, sequence, job.tracker)
            elif index > one.run.first:
                one.step(image, index)
    return passes
