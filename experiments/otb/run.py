"""Runs trackers over sequences by a protocol; one file of boxes for each, so that runs resume.

`DIR/boxes/PROTOCOL/TRACKER/SEED/SEQUENCE.csv` has a line `run,frame,x,y,w,h` for each frame, x and
y 1-based as in the ground truth. A file is there when its sequence is done, and never half.
"""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.otb.contestants import CONTESTANTS
from experiments.otb.protocols import PROTOCOLS, Run
from experiments.otb.sequences import VideoSequence, load_sequence
from tracker.box_tracker import BoxTracker


@dataclass(frozen=True)
class Job:
    """One tracker with one seed on one sequence by one protocol."""

    root: Path
    sequence: str
    tracker: str
    protocol: str
    seed: int

    def path(self, out: Path) -> Path:
        """Where its boxes go."""
        folder = out / "boxes" / self.protocol / self.tracker / str(self.seed)
        return folder / f"{self.sequence}.csv"


def run_jobs(
    jobs: Sequence[Job], out: Path, workers: int
) -> Generator[tuple[Job, str | None], None, None]:
    """Runs the jobs and yields each with None, or with the one line that says why it failed."""
    context = multiprocessing.get_context("spawn")
    with context.Pool(workers, initializer=_one_thread) as pool:
        yield from pool.imap_unordered(_Work(out), jobs)


@dataclass(frozen=True)
class _Work:
    out: Path

    def __call__(self, job: Job) -> tuple[Job, str | None]:
        try:
            sequence = load_sequence(job.root / job.sequence)
            text = "".join(
                f"{run.name},{run.first + k},{','.join(f'{v:.4f}' for v in box)}\n"
                for number, run in enumerate(PROTOCOLS[job.protocol](sequence))
                for k, box in enumerate(track(job, sequence, run, number))
            )
        except ValueError as error:
            return job, f"{job.sequence}: {error}"
        path = job.path(self.out)
        path.parent.mkdir(parents=True, exist_ok=True)
        partial = path.with_suffix(f".{os.getpid()}.part")
        partial.write_text(text, encoding="utf-8")
        partial.replace(path)
        return job, None


def track(job: Job, sequence: VideoSequence, run: Run, number: int) -> np.ndarray:
    """(n, 4) boxes of one run, 1-based, from its first frame to the end of the sequence."""
    rng = np.random.default_rng([job.seed, number])
    tracker: BoxTracker = CONTESTANTS[job.tracker].make(rng)
    tracker.start(sequence.image(run.first), run.box - [1, 1, 0, 0])
    boxes = [run.box]
    for index in range(run.first + 1, len(sequence)):
        boxes.append(tracker.update(sequence.image(index)) + [1, 1, 0, 0])
    return np.array(boxes)


def _one_thread() -> None:
    import cv2

    cv2.setNumThreads(1)
