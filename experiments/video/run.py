"""Runs trackers over a folder of sequences; the same command again resumes, file by file."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from tqdm import tqdm

from experiments.catalogue import require_known
from experiments.study.processes import Lost, run_all
from experiments.study.progress import progress_bar
from experiments.study.results_folder import exclusive
from experiments.video import folder
from experiments.video.contestants import get_contestant
from experiments.video.images import SequenceError
from experiments.video.jobs import Job, plan
from experiments.video.protocols import PROTOCOLS
from experiments.video.selection import select
from experiments.video.sequences import (
    VideoSequence,
    find_sequences,
    load_sequence,
    read_attributes,
)
from experiments.video.tracking import Done, Tracking


@dataclass(frozen=True)
class OtbRun:
    """What to run."""

    root: Path
    trackers: tuple[str, ...]
    protocols: tuple[str, ...]
    seed_count: int = 1
    wanted: tuple[tuple[str, str], ...] = ()
    """Sequences, attributes or TB-50, and where each word stands; all sequences if empty."""

    def __post_init__(self) -> None:
        for tracker in self.trackers:
            get_contestant(tracker)
        for protocol in self.protocols:
            require_known("protocol", protocol, PROTOCOLS)
        for name in ("trackers", "protocols"):
            if not getattr(self, name):
                raise ValueError(f"{name} must name one at least")
        if self.seed_count < 1:
            raise ValueError(f"seeds must be 1 or greater, got {self.seed_count}")


class Complaints:
    """One line on stderr for each thing that went wrong, told once."""

    def __init__(self) -> None:
        self._told: set[str] = set()

    def __len__(self) -> int:
        return len(self._told)

    def tell(self, complaint: str) -> None:
        """Prints the line above the progress bar, unless it is there already."""
        line = " ".join(complaint.split())
        if line not in self._told:
            self._told.add(line)
            tqdm.write(f"beltgrasp: error: {line}", file=sys.stderr)


def run_otb(request: OtbRun, out: Path, workers: int) -> tuple[int, int]:
    """Runs what `out` lacks; the numbers of jobs that are done and of things that went wrong.

    Args:
        request: What to run. Trackers, protocols, seeds and sequences may differ from those of
            earlier calls with the same folder; the root and the settings of a tracker may not.
        out: Results folder.
        workers: Number of worker processes; the files do not depend on it.
    """
    if workers < 1:
        raise ValueError(f"workers must be 1 or greater, got {workers}")
    complaints = Complaints()
    sequences = _load(request, complaints)
    jobs, unable = plan(sequences, request.trackers, request.protocols, request.seed_count)
    for complaint in unable:
        complaints.tell(complaint)
    if jobs:
        with exclusive(out):
            folder.open_manifest(out, request.root, request.trackers, workers)
            _run_missing(jobs, out, workers, complaints)
    return sum(job.boxes_path(out).exists() for job in jobs), len(complaints)


def _load(request: OtbRun, complaints: Complaints) -> list[VideoSequence]:
    """The sequences that were asked for; a complaint about each that cannot be used."""
    found = find_sequences(request.root)
    names = list(found)
    if request.wanted:
        names, unknown = select(_attributes(found), request.wanted)
        for complaint in unknown:
            complaints.tell(complaint)
    sequences: list[VideoSequence] = []
    for name in names:
        try:
            sequences.append(load_sequence(name, found[name]))
        except SequenceError as error:
            complaints.tell(f"{name}: {error}")
    for sequence in sequences:
        if sequence.spare_image_count:
            line = sequence.line(len(sequence) - 1)
            spare = f"{sequence.spare_image_count} images have no box and do not count"
            print(f"note: {sequence.name}: {line} is the last: {spare}", file=sys.stderr)
    return sequences


def _attributes(found: Mapping[str, Path]) -> dict[str, tuple[str, ...]]:
    """Challenges of each sequence; none for one whose list is faulty, which loading it tells."""
    tags: dict[str, tuple[str, ...]] = dict.fromkeys(found, ())
    for name, path in found.items():
        with contextlib.suppress(SequenceError):
            tags[name] = read_attributes(name, path.parent)
    return tags


def _run_missing(jobs: Sequence[Job], out: Path, workers: int, complaints: Complaints) -> None:
    missing = [job for job in jobs if not job.boxes_path(out).exists()]
    _announce(jobs, missing, workers)
    answers = run_all(Tracking(out), missing, workers)
    total, left = (sum(job.frame_count for job in group) for group in (jobs, missing))
    with contextlib.closing(answers), progress_bar("otb", "frame", total, total - left) as bar:
        for answer in answers:
            done = answer
            if isinstance(done, Lost):
                done = Done(done.task, f"{done.task.boxes_path(out)}: {done.remark}")
            if done.complaint is not None:
                complaints.tell(done.complaint)
            bar.set_postfix_str(f"{done.job.tracker} {done.job.sequence}", refresh=False)
            bar.update(done.job.frame_count)


def _announce(jobs: Sequence[Job], missing: Sequence[Job], workers: int) -> None:
    done = len(jobs) - len(missing)
    already = f", {done} of them done" if done else ""
    frames = sum(job.frame_count for job in missing)
    print(
        f"otb: {len({job.sequence for job in jobs})} sequences, {len(jobs)} files{already}; "
        f"{frames} frames to go with {workers} worker{'s' * (workers > 1)}",
        file=sys.stderr,
        flush=True,
    )
