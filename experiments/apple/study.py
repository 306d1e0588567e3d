"""The three studies of apples: the published tables, their poses again, and approaches."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from experiments.apple.approach import ApproachJob, ApproachRow
from experiments.apple.estimates import FILTERS, EstimateJob, EstimateRow, estimate_rows
from experiments.apple.photographs import SEGMENTED
from experiments.apple.published import TABLES, published_table
from experiments.apple.rendered_tables import BEST
from experiments.apple.replay import ReplayJob, ReplayRow
from experiments.apple.worlds import WorldId
from experiments.study.study import Result, Score, Selection, Study
from tracker.apple.attitude import axis_error_deg, unit
from tracker.apple.filters import PointFilterConfig
from tracker.checks import require_known

FAR_OFF_DEG = 10.0
"""An approach that ends with a larger error of its best method is a failure."""


def get_study(name: str) -> Study[Any, Any]:
    """The study of that name; ValueError that lists the known ones for another."""
    require_known("study", name, STUDIES)
    return STUDIES[name]


def estimate_jobs(selection: Selection) -> list[EstimateJob]:
    """Both tables through the particle filter at every seed, and through the exact filters."""
    config = PointFilterConfig(**selection["filter"])
    return [
        EstimateJob(table, name, seed, config)
        for table in TABLES
        for name in FILTERS
        for seed in (selection["seeds"] if name == FILTERS[0] else [0])
    ]


def replay_jobs(selection: Selection) -> list[ReplayJob]:
    """Every table with every fruit."""
    return [
        ReplayJob(table, aspect, seed)
        for table in selection["tables"]
        for aspect in selection["aspects"]
        for seed in selection["seeds"]
    ]


def approach_jobs(selection: Selection) -> list[ApproachJob]:
    """Every way to look at every world."""
    return [
        ApproachJob(WorldId(fruit_class, aspect, seed), views)
        for fruit_class in selection["classes"]
        for aspect in selection["aspects"]
        for views in selection["views"]
        for seed in selection["seeds"]
    ]


def run_estimates(jobs: Sequence[EstimateJob]) -> list[Result[EstimateRow]]:
    """Runs filters over the published measurements."""
    return [Result(tuple(estimate_rows(job))) for job in jobs]


def rendered_settings(job: Any) -> Mapping[str, object]:
    """The methods and masks that are tried, all that they are set to, and the arm's pose noise."""
    from experiments.apple.methods import METHODS
    from experiments.apple.photographs import MASKS
    from sim.apple.eye_in_hand import PoseNoise
    from tracker.apple.next_view import NextViewConfig
    from tracker.apple.outline_views import OutlineModelConfig
    from tracker.apple.segmentation import SegmentationConfig
    from tracker.apple.silhouette_fit import SilhouetteFitConfig
    from tracker.apple.single_view import SingleViewConfig

    del job
    configs = (
        SegmentationConfig(),
        SingleViewConfig(),
        PointFilterConfig(),
        SilhouetteFitConfig(),
        OutlineModelConfig(),
        NextViewConfig(),
    )
    own = {type(config).__name__: config for config in configs}
    return {"methods": [*METHODS], "masks": [*MASKS], "pose noise": PoseNoise(), **own}


def filter_settings(job: EstimateJob) -> Mapping[str, object]:
    """The settings of the point filters."""
    return {"filter": job.config}


def order_of(job: Any) -> Any:
    """The place of a job's rows: by class or table, aspect and seed."""
    return job.place


def is_far_off(rows: Sequence[ApproachRow]) -> bool:
    """Whether the best method, on segmented images, ends far from the axis."""
    return any(
        row.error_deg > FAR_OFF_DEG for row in rows if (row.mask, row.method) == (SEGMENTED, BEST)
    )


def estimate_error(row: EstimateRow) -> tuple[Any, float] | None:
    """The axis error after the last image of a table."""
    table = published_table(row.table)
    if row.image != len(table.robot_deg):
        return None
    axis = unit(np.cos(np.radians([row.x_deg, row.y_deg, row.z_deg])))
    return (row.table, row.seed), float(axis_error_deg(axis, table.true_axis))


def replay_error(row: ReplayRow) -> tuple[Any, float] | None:
    """The axis error after the last image of a table, on segmented images."""
    is_last = row.image == len(published_table(row.table).robot_deg)
    if row.mask != SEGMENTED or not is_last:
        return None
    return (row.table, row.aspect, row.seed), row.error_deg


def approach_error(row: ApproachRow) -> tuple[Any, float] | None:
    """The axis error at the end of an approach, on segmented images."""
    if row.mask != SEGMENTED:
        return None
    return (row.fruit_class, row.aspect, row.seed, row.views), row.error_deg


_ERROR = "axis error [deg]"

STUDIES: dict[str, Study[Any, Any]] = {
    "apple/tables": Study(
        name="apple/tables",
        unit="filter run",
        row=EstimateRow,
        key=("table", "filter", "seed"),
        jobs=estimate_jobs,
        work="experiments.apple.study:run_estimates",
        settings=filter_settings,
        report="experiments.apple.report:tables_report",
        title=str,
        method="filter",
        score=Score(estimate_error, _ERROR, higher_is_better=False),
        order=order_of,
    ),
    "apple/replay": Study(
        name="apple/replay",
        unit="world",
        row=ReplayRow,
        key=("table", "aspect", "seed"),
        jobs=replay_jobs,
        work="experiments.apple.replay:run_replays",
        settings=rendered_settings,
        report="experiments.apple.report:replay_report",
        title=str,
        method="method",
        score=Score(replay_error, _ERROR, higher_is_better=False),
        order=order_of,
        needs_rendering=True,
    ),
    "apple/approach": Study(
        name="apple/approach",
        unit="world",
        row=ApproachRow,
        key=("fruit_class", "aspect", "seed", "views"),
        jobs=approach_jobs,
        work="experiments.apple.approach:run_approaches",
        settings=rendered_settings,
        report="experiments.apple.report:approach_report",
        title=str,
        method="method",
        score=Score(approach_error, _ERROR, higher_is_better=False),
        order=order_of,
        identity=ApproachJob.columns,
        needs_rendering=True,
        is_failure=is_far_off,
        film="experiments.apple.film:film_approach",
    ),
}
"""Every study of apples by name."""
