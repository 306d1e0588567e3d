"""The studies of video: trackers on sequences by the protocols of OTB; rendered sequences."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from experiments.report.table import csv_line
from experiments.study.study import Score, Selection, Study
from experiments.video.job import AFFINE, AFFINE_COLUMNS, HITS, KEY, VideoJob, VideoRow
from experiments.video.protocols import PROTOCOLS
from experiments.video.rendered import RenderJob, RenderRow
from experiments.video.scores import HIT_COLUMNS
from experiments.video.trackers import VIDEO_TRACKERS, get_video_tracker
from tracker.checks import require_known

LOW_OVERLAP = 0.5
"""A tracker that scores less on a sequence has failed there."""


def get_study(name: str) -> Study[Any, Any]:
    """The study of that name; ValueError that lists the known ones for another."""
    require_known("study", name, STUDIES)
    return STUDIES[name]


def video_jobs(selection: Selection) -> list[VideoJob]:
    """Every tracker with every seed on every sequence; one seed for what draws nothing."""
    return [
        VideoJob(protocol, sequence, tracker, seed, selection["root"])
        for protocol in selection["protocols"]
        for sequence in selection["sequences"]
        for tracker in selection["trackers"]
        for seed in (selection["seeds"] if get_video_tracker(tracker).is_random else [0])
    ]


def video_settings(job: VideoJob) -> Mapping[str, object]:
    """The settings of the tracker, and the ground truth of the sequence."""
    from experiments.video.sequences import find_sequences

    truth = find_sequences(Path(job.root))[job.sequence]
    return {
        f"tracker {job.tracker}": get_video_tracker(job.tracker).settings,
        f"sequence {job.sequence}": truth,
    }


def place_of(job: VideoJob) -> tuple[Any, ...]:
    """By protocol, sequence, tracker in the order of the registry, and seed."""
    known = [*VIDEO_TRACKERS]
    place = known.index(job.tracker) if job.tracker in known else len(known)
    return [*PROTOCOLS].index(job.protocol), job.sequence, place, job.tracker, job.seed


def has_low_overlap(rows: Sequence[VideoRow]) -> bool:
    """Whether the tracker has lost the target for most of the sequence."""
    score = rows[0].overlap_score
    return score is not None and score < LOW_OVERLAP


def overlap_of_sequence(row: VideoRow) -> tuple[Any, float] | None:
    """What a tracker met, and its overlap score there; None for a job that crashed."""
    if row.overlap_score is None:
        return None
    return (row.protocol, row.sequence), row.overlap_score


def render_jobs(selection: Selection) -> list[RenderJob]:
    """Every sequence of the benchmark that is asked for, at one seed."""
    return [RenderJob(name, selection["seed"]) for name in selection["names"]]


def render_settings(job: RenderJob) -> Mapping[str, object]:
    """What the sequence shows, and the seed of the benchmark."""
    from experiments.video.clips import RECIPES

    return {f"clip {job.name}": RECIPES[job.name], "seed": job.seed}


def place_of_clip(job: RenderJob) -> int:
    """In the order of the benchmark."""
    from experiments.video.clips import RECIPES

    return [*RECIPES].index(job.name)


STUDIES: dict[str, Study[Any, Any]] = {
    "video/otb": Study(
        name="video/otb",
        unit="file",
        row=VideoRow,
        key=KEY,
        jobs=video_jobs,
        work="experiments.video.tracking:run_jobs",
        settings=video_settings,
        report="experiments.video.report:write_report",
        title=str,
        method="tracker",
        score=Score(overlap_of_sequence, "overlap score", higher_is_better=True),
        order=place_of,
        curves={HITS: csv_line([*KEY, *HIT_COLUMNS]), AFFINE: csv_line(AFFINE_COLUMNS)},
        is_failure=has_low_overlap,
        film="experiments.video.film:film",
    ),
    "video/sequences": Study(
        name="video/sequences",
        unit="sequence",
        row=RenderRow,
        key=("name",),
        jobs=render_jobs,
        work="experiments.video.make:render_sequences",
        settings=render_settings,
        report="experiments.video.make:write_index",
        title=str,
        order=place_of_clip,
        needs_rendering=True,
        film="experiments.video.film:film_sequence",
    ),
}
"""Every study of video by name."""
