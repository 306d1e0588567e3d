"""The published measurements through the filters: a row for each table, filter, seed and image."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.apple.published import TABLES, PublishedTable, published_table
from experiments.seeding import Stream, generator
from experiments.study.records import header_line, read_rows, row_line, write_whole
from tracker.apple.filters import PointFilterConfig, kalman_estimates, particle_estimates

ESTIMATES = "estimates.csv"
PARTICLES, KALMAN, KALMAN_SIGNED = "particles", "kalman", "kalman-signed"
FILTERS = (PARTICLES, KALMAN, KALMAN_SIGNED)
"""The filter of [Zhou2011]; its exact form; and that on the camera column brought to the robot's
frame with the signs that Table 1 folds away."""


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


def estimate_rows(config: PointFilterConfig, seed_count: int) -> Iterator[EstimateRow]:
    """All rows, in the order of the file."""
    for number in TABLES:
        table = published_table(number)
        measured = np.cos(np.radians(table.robot_deg))
        for seed in range(seed_count):
            rng = generator(seed, Stream.TRACKER, f"apple table {number}")
            yield from _rows(table, PARTICLES, seed, particle_estimates(measured, config, rng))
        yield from _rows(table, KALMAN, 0, kalman_estimates(measured, config))
        yield from _rows(table, KALMAN_SIGNED, 0, kalman_estimates(table.converted, config))


def _rows(
    table: PublishedTable, name: str, seed: int, estimates: np.ndarray
) -> Iterator[EstimateRow]:
    angles = np.degrees(np.arccos(np.clip(estimates, -1.0, 1.0)))
    lengths = np.linalg.norm(estimates, axis=1)
    for image, (angle, length) in enumerate(zip(angles, lengths, strict=True), start=1):
        x, y, z = map(float, angle)
        yield EstimateRow(table.number, name, seed, image, x, y, z, float(length))


def write_estimates(folder: Path, rows: Iterator[EstimateRow]) -> Path:
    """Writes all rows in one step."""
    path = folder / ESTIMATES
    write_whole(path, header_line(EstimateRow) + "".join(map(row_line, rows)))
    return path


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


def read_estimates(folder: Path) -> Estimates:
    """The rows in `folder`; ValueError where they are missing or of other columns."""
    path = folder / ESTIMATES
    rows = read_rows(path, EstimateRow, "apple tables")
    angles: dict[tuple[int, str], np.ndarray] = {}
    lengths: dict[tuple[int, str], np.ndarray] = {}
    for number in TABLES:
        image_count = len(published_table(number).robot_deg)
        for name in FILTERS:
            chosen = [r for r in rows if (r.table, r.filter) == (number, name)]
            shape = (len(chosen) // image_count, image_count)
            if not chosen or shape[0] * image_count != len(chosen):
                raise ValueError(f"{path} does not hold every image of {name}, table {number}")
            cells = np.array([[r.x_deg, r.y_deg, r.z_deg] for r in chosen])
            angles[number, name] = cells.reshape(*shape, 3)
            lengths[number, name] = np.array([r.length for r in chosen]).reshape(shape)
    return Estimates(angles, lengths)
