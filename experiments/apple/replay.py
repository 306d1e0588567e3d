"""The eleven published camera poses taken again, with a rendered apple where the fruit hung.

The fruit hangs where the published optical axes nearly meet, with the attitude that was set up.
The poses are turned until they look at it: as printed, some miss it by centimetres. Where the UR5
reaches a pose it carries the camera there, else a free camera takes the image.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from experiments.apple.approach import errors_deg
from experiments.apple.methods import METHODS
from experiments.apple.photographs import MASKS, ArmPhotographer, Photograph, sighting
from experiments.apple.published import TABLES, published_table
from experiments.apple.worlds import draw_light
from experiments.seeding import Stream, generator
from experiments.study.rows import JobOutcome
from experiments.study.study import Result
from sim.apple.fruit import Fruit, PlacedFruit
from sim.apple.leaves import leaves_behind
from sim.apple.world import Orchard, OrchardConfig
from sim.geometry import look_at
from tracker.apple.attitude import angles_deg, axis_error_deg, unit
from tracker.geometry import least_rotation

_LEAVES = 12


@dataclass(frozen=True)
class ReplayJob:
    """One table with one fruit."""

    table: int
    aspect: float
    seed: int

    def __post_init__(self) -> None:
        if self.table not in TABLES:
            raise ValueError(f"table must be one of {TABLES}, got {self.table!r}")

    def __str__(self) -> str:
        return f"Table {self.table}, aspect {self.aspect:g}, seed {self.seed}"

    @property
    def place(self) -> tuple[Any, ...]:
        """By table, aspect and seed."""
        return self.table, self.aspect, self.seed


@dataclass(frozen=True)
class ReplayRow:
    """What one method says after one image."""

    table: int
    aspect: float
    seed: int
    mask: str
    method: str
    image: int
    """Counted from 1, as published."""
    by_arm: bool
    """Whether the UR5 carried the camera; a free one else."""
    range_m: float
    """From the camera to the fruit."""
    status: str
    """Of the segmentation."""
    is_calyx_found: bool
    x_deg: float | None
    """Angle of the estimated axis with the robot's x axis; None without an estimate."""
    y_deg: float | None
    z_deg: float | None
    error_deg: float
    """Axis error, sign-blind; 90 without an estimate."""
    outcome: JobOutcome = "done"
    detail: str = ""


def run_replays(jobs: Sequence[ReplayJob]) -> list[Result[ReplayRow]]:
    """Takes the images of tables again, one after the other."""
    return [Result(tuple(replay_rows(job))) for job in jobs]


def replay_rows(job: ReplayJob) -> list[ReplayRow]:
    """Takes the images of a table and runs every method on them, with both kinds of masks."""
    config, poses = draw_replay(job)
    paint = generator(job.seed, Stream.SCENE, "apple replay paint")
    with Orchard(config, paint) as orchard:
        photographer = ArmPhotographer(orchard, job.seed, free_if_unreachable=True)
        photographs = [photo for T in poses if (photo := photographer(T)) is not None]
    rows: list[ReplayRow] = []
    for mask in MASKS:
        for name in METHODS:
            rows += _rows(job, mask, name, photographs, config.fruit)
    return rows


def draw_replay(job: ReplayJob) -> tuple[OrchardConfig, list[np.ndarray]]:
    """The world of a table, and its camera poses (4, 4), turned to look at the fruit."""
    table = published_table(job.table)
    rng = generator(job.seed, Stream.SCENE, f"apple replay {job.table}")
    fruit = PlacedFruit(
        Fruit(radius_m=rng.uniform(0.036, 0.044), aspect=job.aspect),
        table.fruit_m.copy(),
        table.true_axis.copy(),
    )
    eye = table.position_m.mean(axis=0)
    frame = look_at(eye, fruit.centre_m)[:3, :3]
    leaves = leaves_behind(rng, fruit.centre_m, frame, _LEAVES)
    light, from_m = draw_light(rng, frame), (float(eye[0]), float(eye[1]), float(eye[2]))
    config = OrchardConfig(fruit, leaves=leaves, light=light, backdrop_from_m=from_m)
    return config, [
        aimed(pose.rotation, pose.position_m, fruit.centre_m) for pose in table.camera_poses
    ]


def aimed(rotation: np.ndarray, position_m: np.ndarray, point_m: np.ndarray) -> np.ndarray:
    """(4, 4) pose of the camera, turned by the least that brings its optical axis to a point."""
    T = np.eye(4)
    T[:3, :3] = least_rotation(rotation[:, 2], point_m - position_m) @ rotation
    T[:3, 3] = position_m
    return T


def _rows(
    job: ReplayJob, mask: str, name: str, photographs: Sequence[Photograph], fruit: PlacedFruit
) -> list[ReplayRow]:
    sightings = [sighting(photograph, mask) for photograph in photographs]
    estimates = METHODS[name].run(sightings, job.seed)
    errors = errors_deg(estimates, fruit.axis)
    rows: list[ReplayRow] = []
    for index, (photograph, seen) in enumerate(zip(photographs, sightings, strict=True)):
        estimate = estimates[index]
        angles = [None] * 3 if estimate is None else angles_deg(estimate.axis).tolist()
        columns: dict[str, Any] = dict(zip(("x_deg", "y_deg", "z_deg"), angles, strict=True))
        rows.append(
            ReplayRow(
                **asdict(job),
                mask=mask,
                method=name,
                image=index + 1,
                by_arm=photograph.by_arm,
                range_m=float(np.linalg.norm(photograph.true_pose[:3, 3] - fruit.centre_m)),
                status=str(seen.view.status),
                is_calyx_found=seen.view.calyx_px is not None,
                **columns,
                error_deg=errors[index],
            )
        )
    return rows


def published_errors_deg(table: int) -> tuple[float, float]:
    """Mean axis error of the published single images, and the error of the published end."""
    published = published_table(table)
    single = axis_error_deg(unit(np.cos(np.radians(published.robot_deg))), published.true_axis)
    end = unit(np.cos(np.radians(published.estimate_deg[-1])))
    return float(single.mean()), float(axis_error_deg(end, published.true_axis))
