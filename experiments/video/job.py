"""One tracker with one seed on one sequence by one protocol, and the row that this leaves."""

from dataclasses import dataclass, fields

from experiments.study.rows import JobOutcome

HITS, AFFINE = "curves", "affine"
"""Names of the files of curves: frames within each threshold, and affine errors by frame."""

KEY = ("protocol", "sequence", "tracker", "seed")
"""Columns that name a job."""


@dataclass(frozen=True)
class VideoJob:
    """All runs of one tracker with one seed on one sequence by one protocol."""

    protocol: str
    sequence: str
    tracker: str
    seed: int
    root: str
    """Folder of the sequences."""

    def __str__(self) -> str:
        return f"{self.tracker} on {self.sequence}, {self.protocol}, seed {self.seed}"

    @property
    def boxes_path(self) -> str:
        """Where its boxes go in the results folder."""
        return f"boxes/{self.protocol}/{self.tracker}/{self.seed}/{self.sequence}.csv"


@dataclass(frozen=True)
class VideoRow:
    """The scores of a job, over all frames of all its runs."""

    protocol: str
    sequence: str
    tracker: str
    seed: int
    """0 for trackers that draw nothing at random."""
    outcome: JobOutcome
    run_count: int
    frame_count: int
    distance_precision: float | None
    """Share of the frames with a centre error of at most 20 px."""
    overlap_score: float | None
    """Mean share of the frames over the overlap thresholds, the area of the success curve."""
    attributes: str
    """Challenges of the sequence, separated by blanks."""
    detail: str = ""
    commit: str = ""


@dataclass(frozen=True)
class AffineRow:
    """The affine errors on one frame of one run. None where the tracker reports no warp."""

    run: str
    frame: int
    """Counted from 1."""
    corner_error_px: float
    """Mean distance of the target's four corners from where the tracker puts them."""
    scale_error: float | None
    """Logarithm of estimated over true scale."""
    aspect_error: float | None
    rotation_error_rad: float | None
    shear_error: float | None
    nees: float | None
    """Squared Mahalanobis distance of the true warp; 6 on average for an honest covariance."""
    ess: float | None
    ancestor_count: int | None
    """Particles that have descendants after resampling; None where nothing was resampled."""
    resampling_distance: float | None
    """Energy distance between the weighted particles before resampling and those after it."""
    visible: float
    """Share of the target that can be seen, from 0 to 1."""


AFFINE_COLUMNS = (*KEY, *(field.name for field in fields(AffineRow)))
