"""What came out of Tables 1 and 2 of [Zhou2011], beside what was published."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from experiments.apple.convention import readings
from experiments.apple.estimates import KALMAN, KALMAN_SIGNED, PARTICLES, Estimates
from experiments.apple.published import TABLES, PublishedTable, published_table
from experiments.report.table import Column, Table, TableRow, show_number
from tracker.apple.attitude import angle_between_deg, axis_error_deg, folded_deg, unit
from tracker.apple.filters import PointFilterConfig, kalman_estimates

AXES = "xyz"
RATIOS = (0.2, 0.25, 0.3, 0.35, 0.4, 0.5, 0.7, 1.0)
"""Deviations of the random walk, relative to that of a measurement, that are tried."""


def all_tables(estimates: Estimates) -> dict[str, Table]:
    """Every table of the study under the name of its file."""
    return {
        "agreement": agreement_table(estimates),
        "table1": estimate_table(estimates, 1),
        "table2": estimate_table(estimates, 2),
        "errors": error_table(estimates),
        "conversion": conversion_table(),
        "folding": folding_table(estimates),
        "convention": convention_table(),
        "ratio": ratio_table(),
    }


def estimate_table(estimates: Estimates, number: int) -> Table:
    """Each image: measured, published estimate, ours by particles and exact, and axis errors."""
    table = published_table(number)
    particles = estimates.angles_deg[number, PARTICLES]
    columns = {
        "measured": table.robot_deg,
        "published": table.estimate_deg,
        "particles": particles.mean(axis=0),
        "particles_sd": particles.std(axis=0, ddof=1) if len(particles) > 1 else None,
        "kalman": estimates.mean_deg(number, KALMAN),
    }
    rows: list[TableRow] = []
    for i in range(len(table.robot_deg)):
        row: TableRow = {"image": i + 1}
        for name, values in columns.items():
            for j, axis in enumerate(AXES):
                row[f"{name}_{axis}_deg"] = None if values is None else float(values[i, j])
        for name in ("measured", "published", "particles"):
            angles = columns[name]
            assert angles is not None
            row[f"{name}_error_deg"] = _error(table, angles[i])
        rows.append(row)
    count = len(particles)
    return Table(
        tuple(rows),
        (
            Column("image", lambda row: str(row["image"])),
            Column("measured x, y, z [deg]", partial(_three, name="measured", digits=0)),
            Column("published estimate", partial(_three, name="published")),
            Column(f"particles, mean of {count}", partial(_three, name="particles")),
            Column("sd over seeds", partial(_three, name="particles_sd")),
            Column("Kalman", partial(_three, name="kalman")),
            _number("axis error measured", "measured_error_deg", 1),
            _number("published", "published_error_deg", 1),
            _number("particles", "particles_error_deg", 1),
        ),
    )


def agreement_table(estimates: Estimates) -> Table:
    """How far the filters are from the published rows, all but the first, which is given."""
    rows: list[TableRow] = []
    for number in TABLES:
        published = published_table(number).estimate_deg
        for name in (PARTICLES, KALMAN):
            off = estimates.angles_deg[number, name] - published
            of_seed = np.abs(off[:, 1:]).mean(axis=(1, 2))
            final = off[:, -1].mean(axis=0)
            rows.append(
                {
                    "table": number,
                    "filter": name,
                    "n": len(off),
                    "deviation_deg": float(of_seed.mean()),
                    "deviation_p95_deg": float(np.percentile(of_seed, 95)),
                    **{f"final_{a}_deg": float(v) for a, v in zip(AXES, final, strict=True)},
                    "largest_final_deg": float(np.abs(final).max()),
                }
            )
    return Table(
        tuple(rows),
        (
            *_words("table", "filter", "n"),
            _number("mean deviation [deg]", "deviation_deg"),
            _number("95 % of seeds below", "deviation_p95_deg"),
            Column("final row, x, y, z", partial(_three, name="final", sign="+")),
            _number("largest", "largest_final_deg"),
        ),
    )


def error_table(estimates: Estimates) -> Table:
    """Axis errors against the attitude that was set up: single images beside the filter's end."""
    rows: list[TableRow] = []
    for number in TABLES:
        table = published_table(number)
        single = [_error(table, angles) for angles in table.robot_deg]
        published = _error(table, table.estimate_deg[-1])
        final = estimates.angles_deg[number, PARTICLES][:, -1]
        ours = [_error(table, angles) for angles in final]
        rows.append(
            {
                "table": number,
                "images": len(single),
                "single_mean_deg": float(np.mean(single)),
                "single_best_deg": float(np.min(single)),
                "published_final_deg": published,
                "particles_final_median_deg": float(np.median(ours)),
                "images_below_published": int((np.array(single) < published).sum()),
                "measured_mean_deg": float(
                    axis_error_deg(_mean_axis(table.robot_deg), table.true_axis)
                ),
            }
        )
    return Table(
        tuple(rows),
        (
            *_words("table", "images"),
            _number("single image, mean [deg]", "single_mean_deg", 1),
            _number("best image", "single_best_deg", 1),
            _number("mean of all images", "measured_mean_deg", 1),
            _number("filter, published", "published_final_deg", 1),
            _number("filter, median of ours", "particles_final_median_deg", 1),
            Column("images better than the filter", lambda row: str(row["images_below_published"])),
        ),
    )


def conversion_table() -> Table:
    """The published camera columns, brought to the robot's frame, beside the robot columns."""
    rows: list[TableRow] = []
    for number in TABLES:
        table = published_table(number)
        signed = np.degrees(np.arccos(np.clip(table.converted, -1.0, 1.0)))
        for i, (ours, theirs) in enumerate(zip(signed, table.robot_deg, strict=True), start=1):
            off = folded_deg(ours) - folded_deg(theirs) if number == 1 else ours - theirs
            rows.append(
                {
                    "table": number,
                    "image": i,
                    **{f"published_{a}_deg": float(v) for a, v in zip(AXES, theirs, strict=True)},
                    **{f"converted_{a}_deg": float(v) for a, v in zip(AXES, ours, strict=True)},
                    "folded": number == 1,
                    **{f"residual_{a}_deg": float(v) for a, v in zip(AXES, off, strict=True)},
                    "largest_deg": float(np.abs(off).max()),
                }
            )
    return Table(
        tuple(rows),
        (
            *_words("table", "image"),
            Column("published x, y, z [deg]", partial(_three, name="published", digits=0)),
            Column("converted, signs kept", partial(_three, name="converted", digits=1)),
            Column("residual", partial(_three, name="residual", sign="+")),
            _number("largest", "largest_deg"),
        ),
    )


def folding_table(estimates: Estimates) -> Table:
    """The end of Table 1 with signs folded away before the filter, as published, and kept."""
    table = published_table(1)
    finals = {
        "folded, published": table.estimate_deg[-1],
        "folded, Kalman": estimates.mean_deg(1, KALMAN)[-1],
        "signs kept, Kalman": estimates.mean_deg(1, KALMAN_SIGNED)[-1],
    }
    kept = _axis(finals["signs kept, Kalman"])
    rows: list[TableRow] = [
        {
            "input": name,
            **{f"final_{a}_deg": float(v) for a, v in zip(AXES, angles, strict=True)},
            "axis_error_deg": _error(table, angles),
            "from_signed_deg": float(angle_between_deg(_axis(angles), kept)),
        }
        for name, angles in finals.items()
    ]
    return Table(
        tuple(rows),
        (
            *_words("input"),
            Column("final x, y, z [deg]", partial(_three, name="final")),
            _number("axis error", "axis_error_deg", 1),
            _number("away from signs kept", "from_signed_deg", 1),
        ),
    )


def convention_table(count: int = 4) -> Table:
    """The best readings of the published camera angles."""
    rows: list[TableRow] = [
        {
            "order": reading.order,
            "inverse": reading.is_inverse,
            "camera_axes": reading.camera_axes,
            **{
                f"table{number}_deg": residual
                for number, residual in zip(TABLES, reading.residual_deg, strict=True)
            },
        }
        for reading in readings()[:count]
    ]
    return Table(
        tuple(rows),
        (
            Column("turns about fixed axes", lambda row: row["order"]),
            Column("maps", lambda row: "robot to camera" if row["inverse"] else "camera to robot"),
            Column("camera axes", lambda row: row["camera_axes"]),
            *(_number(f"Table {n}, mean residual [deg]", f"table{n}_deg") for n in TABLES),
        ),
    )


def ratio_table() -> Table:
    """Mean deviation of the exact filter from the published rows, by the ratio of its noises."""
    rows: list[TableRow] = []
    for ratio in RATIOS:
        row: TableRow = {"ratio": ratio}
        for number in TABLES:
            table = published_table(number)
            config = PointFilterConfig(measurement_sigma_cm=1.0, walk_sigma_cm=ratio)
            ours = kalman_estimates(np.cos(np.radians(table.robot_deg)), config)
            off = np.degrees(np.arccos(ours)) - table.estimate_deg
            row[f"table{number}_deg"] = float(np.abs(off[1:]).mean())
        rows.append(row)
    return Table(
        tuple(rows),
        (
            _number("q / σ", "ratio"),
            *(_number(f"Table {n} [deg]", f"table{n}_deg") for n in TABLES),
        ),
    )


def _axis(angles_deg: np.ndarray) -> np.ndarray:
    """The direction that estimated angles tell; filters leave it not quite of length one."""
    return unit(np.cos(np.radians(angles_deg)))


def _mean_axis(angles_deg: np.ndarray) -> np.ndarray:
    return unit(np.cos(np.radians(angles_deg)).mean(axis=0))


def _error(table: PublishedTable, angles_deg: np.ndarray) -> float:
    return float(axis_error_deg(_axis(angles_deg), table.true_axis))


def _three(row: TableRow, name: str, digits: int = 2, sign: str = "") -> str:
    values: Sequence[float | None] = [row[f"{name}_{axis}_deg"] for axis in AXES]
    if any(value is None for value in values):
        return "-"
    return ", ".join(f"{value:{sign}.{digits}f}" for value in values)


def _number(label: str, key: str, digits: int = 2) -> Column:
    show: Callable[[TableRow], str] = lambda row: show_number(row[key], digits)  # noqa: E731
    return Column(label, show)


def _words(*names: str) -> tuple[Column, ...]:
    return tuple(Column(name, lambda row, name=name: str(row[name])) for name in names)
