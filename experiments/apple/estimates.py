"""The published measurements through the filters: a row for each table, filter, seed and image."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.apple.published import TABLES, published_table
from experiments.seeding import Stream, generator
from experiments.study.rows import JobOutcome
from tracker.apple.filters import PointFilterConfig, kalman_estimates, particle_estimates

PARTICLES, KALMAN, KALMAN_SIGNED = "particles", "kalman", "kalman-signed"
FILTERS = (PARTICLES, KALMAN, KALMAN_SIGNED)
"""The filter of [Zhou2011]; its exact form; and that on the camera column brought to the robot's
frame with the signs that Table 1 folds away."""


@dataclass(frozen=True)
class EstimateJob:
    """One filter at one seed on the measurements of one table."""

    table: int
    filter: str
    seed: int
    config: PointFilterConfig

    def __str__(self) -> str:
        return f"Table {self.table}, {self.filter}, seed {self.seed}"

    @property
    def place(self) -> tuple[Any, ...]:
        """By table, filter and seed."""
        return self.table, FILTERS.index(self.filter), self.seed


@dataclass(frozen=True)
class EstimateRow:
    """What a filter held after one image."""

    table: int
    filter: str
    seed: int
    """Of the particles; 0 for the exact filters."""
    image: int
    """From 1."""
    x_deg: float
    y_deg: float
    z_deg: float
    length: float
    """Of the estimated vector relative to that of the state: no filter keeps it at 1."""
    outcome: JobOutcome = "done"
    detail: str = ""


def estimate_rows(job: EstimateJob) -> Iterator[EstimateRow]:
    """A row for each image of the table."""
    table = published_table(job.table)
    measured = table.converted if job.filter == KALMAN_SIGNED else table.robot_axes
    if job.filter == PARTICLES:
        rng = generator(job.seed, Stream.TRACKER, f"apple table {job.table}")
        estimates = particle_estimates(measured, job.config, rng)
    else:
        estimates = kalman_estimates(measured, job.config)
    angles = np.degrees(np.arccos(np.clip(estimates, -1.0, 1.0)))
    lengths = np.linalg.norm(estimates, axis=1)
    for image, (angle, length) in enumerate(zip(angles, lengths, strict=True), start=1):
        x, y, z = map(float, angle)
        yield EstimateRow(job.table, job.filter, job.seed, image, x, y, z, float(length))


@dataclass(frozen=True, eq=False)
class Estimates:
    """The rows of a folder, as arrays."""

    angles_deg: dict[tuple[int, str], np.ndarray]
    """(table, filter) -> (seeds, images, 3)"""
    length: dict[tuple[int, str], np.ndarray]
    """(table, filter) -> (seeds, images)"""

    def mean_deg(self, table: int, name: str) -> np.ndarray:
        """(images, 3) mean over the seeds."""
        return self.angles_deg[table, name].mean(axis=0)


def collect_estimates(rows: Sequence[EstimateRow]) -> Estimates:
    """The rows as arrays; ValueError where a filter has not seen every image."""
    angles: dict[tuple[int, str], np.ndarray] = {}
    lengths: dict[tuple[int, str], np.ndarray] = {}
    for number in TABLES:
        image_count = len(published_table(number).robot_deg)
        for name in FILTERS:
            chosen = [r for r in rows if (r.table, r.filter) == (number, name)]
            shape = (len(chosen) // image_count, image_count)
            if not chosen or shape[0] * image_count != len(chosen):
                raise ValueError(f"the rows do not hold every image of {name}, table {number}")
            cells = np.array([[r.x_deg, r.y_deg, r.z_deg] for r in chosen])
            angles[number, name] = cells.reshape(*shape, 3)
            lengths[number, name] = np.array([r.length for r in chosen]).reshape(shape)
    return Estimates(angles, lengths)
