"""Jobs: one tracker with one seed on one sequence by one protocol, and where its results go."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from experiments.video.contestants import get_contestant
from experiments.video.images import SequenceError
from experiments.video.protocols import Run, runs_of
from experiments.video.sequences import VideoSequence


@dataclass(frozen=True)
class Job:
    """All runs of one tracker with one seed on one sequence by one protocol."""

    sequence: str
    ground_truth: Path
    tracker: str
    protocol: str
    seed: int
    frame_count: int
    """Frames of all its runs."""

    def boxes_path(self, out: Path) -> Path:
        """Where its boxes go; the job is done when this file is there."""
        return out / "boxes" / self._place

    def affine_path(self, out: Path) -> Path:
        """Where its affine errors go, if the sequence has affine truth."""
        return out / "affine" / self._place

    def error_path(self, out: Path) -> Path:
        """Where its traceback goes if it crashes."""
        return (out / "errors" / self._place).with_suffix(".txt")

    @property
    def _place(self) -> Path:
        return Path(self.protocol, self.tracker, str(self.seed), f"{self.sequence}.csv")


def plan(
    sequences: Sequence[VideoSequence],
    trackers: Sequence[str],
    protocols: Sequence[str],
    seed_count: int,
) -> tuple[list[Job], list[str]]:
    """The jobs, those of one sequence together, and a line for each sequence that cannot start."""
    jobs: list[Job] = []
    complaints: list[str] = []
    for protocol in protocols:
        for sequence in sequences:
            try:
                frame_count = frames_of(sequence, runs_of(protocol, sequence))
            except SequenceError as error:
                complaints.append(f"{sequence.name}: {error}")
                continue
            jobs += [
                Job(sequence.name, sequence.ground_truth, tracker, protocol, seed, frame_count)
                for tracker in trackers
                for seed in range(seed_count if get_contestant(tracker).is_random else 1)
            ]
    return jobs, complaints


def frames_of(sequence: VideoSequence, runs: Sequence[Run]) -> int:
    """Frames of all runs together."""
    return sum(len(sequence) - run.first for run in runs)
