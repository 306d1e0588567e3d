"""The arm approaches a fruit: every method on the images of every world, one row each.

Errors are between axes, without regard to their sign, which a column of its own tells.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np

from experiments.apple.methods import METHODS, Estimate
from experiments.apple.photographs import (
    MASKS,
    ArmPhotographer,
    Photograph,
    sighting,
    visible_share,
)
from experiments.apple.viewpoints import VIEWS
from experiments.apple.worlds import CLASSES, World, WorldId, draw_world
from experiments.study.rows import JobOutcome
from experiments.study.study import Result
from sim.apple.world import intrinsics
from tracker.apple.attitude import axis_error_deg
from tracker.apple.view import Sighting
from tracker.checks import require_known

NO_ESTIMATE_DEG = 90.0
"""Counts as the error where a method has nothing to tell: the worst there is."""


@dataclass(frozen=True)
class ApproachJob:
    """One world and the way in which its views are chosen."""

    world: WorldId
    views: str = "arc"

    def __post_init__(self) -> None:
        require_known("views", self.views, VIEWS)

    def __str__(self) -> str:
        w = self.world
        return f"{w.fruit_class}, aspect {w.aspect:g}, {self.views}, seed {w.seed}"

    def columns(self) -> dict[str, Any]:
        """The columns that name its rows."""
        return {**asdict(self.world), "views": self.views}

    @property
    def place(self) -> tuple[Any, ...]:
        """Classes in their usual order, then aspects, seeds and ways to look."""
        w = self.world
        return list(CLASSES).index(w.fruit_class), w.aspect, w.seed, list(VIEWS).index(self.views)


@dataclass(frozen=True)
class ApproachRow:
    """One method on the images of one world."""

    fruit_class: str
    aspect: float
    seed: int
    views: str
    """How the camera's places were chosen."""
    mask: str
    """Whether the fruit was told by segmentation or by the oracle."""
    method: str
    image_count: int
    found_count: int
    """Images in which a fruit was found."""
    calyx_count: int
    """Images in which a calyx was found."""
    arm_count: int
    """Images taken by the arm; the others by a free camera."""
    visible_share: float
    """Share of the fruit that nothing hides, median over the images."""
    error_deg: float
    """Axis error after the last image; for a method of single images the mean over all."""
    sigma_deg: float | None
    """The method's own deviation after the last image."""
    is_sign_right: bool
    """Whether stem and calyx are told apart rightly at the end."""
    error_1_deg: float
    error_2_deg: float
    error_3_deg: float
    error_4_deg: float
    error_5_deg: float
    error_6_deg: float
    error_7_deg: float
    error_8_deg: float
    outcome: JobOutcome = "done"
    detail: str = ""


ERROR_FIELDS = tuple(f.name for f in fields(ApproachRow) if f.name.startswith("error_"))[1:]
"""Errors after each image; where the arm could not go on, the last one stands."""


def run_approaches(jobs: Sequence[ApproachJob]) -> list[Result[ApproachRow]]:
    """Approaches fruits, one after the other."""
    return [Result(tuple(approach_rows(job))) for job in jobs]


def approach_rows(job: ApproachJob) -> list[ApproachRow]:
    """Takes the images of one world and runs every method on them, with both kinds of masks."""
    world = draw_world(job.world)
    with world.build() as orchard:
        photographer = ArmPhotographer(orchard, job.world.seed)
        photographs = VIEWS[job.views].take(world.approach, photographer, job.world.seed)
    if not photographs:
        raise RuntimeError("no image: the arm reaches no place of the approach")
    rows: list[ApproachRow] = []
    for mask in MASKS:
        sightings = [sighting(photograph, mask) for photograph in photographs]
        rows += [_row(job, world, mask, name, photographs, sightings) for name in METHODS]
    return rows


def errors_deg(estimates: Sequence[Estimate | None], axis: np.ndarray) -> list[float]:
    """Axis error of each estimate."""
    return [
        NO_ESTIMATE_DEG if e is None else float(axis_error_deg(e.axis, axis)) for e in estimates
    ]


def _row(
    job: ApproachJob,
    world: World,
    mask: str,
    name: str,
    photographs: Sequence[Photograph],
    sightings: Sequence[Sighting],
) -> ApproachRow:
    method, axis = METHODS[name], world.fruit.axis
    estimates = method.run(sightings, job.world.seed)
    errors = errors_deg(estimates, axis)
    last = estimates[-1]
    views = [s.view for s in sightings]
    lasting = errors + [errors[-1]] * (len(ERROR_FIELDS) - len(errors))
    by_image: dict[str, Any] = dict(zip(ERROR_FIELDS, lasting, strict=True))
    return ApproachRow(
        **job.columns(),
        mask=mask,
        method=name,
        image_count=len(views),
        found_count=sum(view.is_found for view in views),
        calyx_count=sum(view.calyx_px is not None for view in views),
        arm_count=sum(photograph.by_arm for photograph in photographs),
        visible_share=float(np.median([_visible(world, p) for p in photographs])),
        error_deg=errors[-1] if method.is_fused else float(np.mean(errors)),
        sigma_deg=None if last is None else last.sigma_deg,
        is_sign_right=last is not None and bool(last.axis @ axis > 0.0),
        **by_image,
    )


def _visible(world: World, photograph: Photograph) -> float:
    outline = world.fruit.outline_px(intrinsics(), photograph.true_pose, 200)
    return visible_share(photograph, outline)
