"""What came out of Tables 1 and 2 of [Zhou2011], beside what was published."""

import numpy as np

from experiments.apple.estimates import KALMAN, KALMAN_SIGNED, PARTICLES, Estimates
from experiments.apple.published import TABLES, PublishedTable, published_table, readings
from experiments.report.table import Column, Table, TableRow, number, show_number, word, words
from tracker.apple.attitude import angle_between_deg, axis_error_deg, folded_deg, unit
from tracker.apple.filters import PointFilterConfig, kalman_estimates

AXES = "xyz"
RATIOS = (0.2, 0.25, 0.3, 0.35, 0.4, 0.5, 0.7, 1.0)
"""Deviations of the random walk, relative to that of a measurement, that are tried."""


def all_tables(estimates: Estimates) -> dict[str, Table]:
    """Returns every table of the study under the name of its file."""
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


def estimate_table(estimates: Estimates, table_number: int) -> Table:
    """Returns each image: measured, published and our estimates, and their axis errors."""
    table = published_table(table_number)
    particles = estimates.angles_deg[table_number, PARTICLES]
    unknown = np.full_like(table.robot_deg, np.nan)
    columns = {
        "measured": table.robot_deg,
        "published": table.estimate_deg,
        "particles": particles.mean(axis=0),
        "particles_sd": particles.std(axis=0, ddof=1) if len(particles) > 1 else unknown,
        "kalman": estimates.mean_deg(table_number, KALMAN),
    }
    rows: list[TableRow] = []
    for i in range(len(table.robot_deg)):
        row: TableRow = {"image": i + 1}
        for name, angles in columns.items():
            row |= _by_axis(name, angles[i])
        for name in ("measured", "published", "particles"):
            row[f"{name}_error_deg"] = _error(table, columns[name][i])
        rows.append(row)
    count = len(particles)
    return Table.of(
        rows,
        *words("image"),
        _three("measured x, y, z [deg]", "measured", digits=0),
        _three("published estimate", "published"),
        _three(f"particles, mean of {count}", "particles"),
        _three("sd over seeds", "particles_sd"),
        _three("Kalman", "kalman"),
        number("axis error measured", "measured_error_deg", 1),
        number("published", "published_error_deg", 1),
        number("particles", "particles_error_deg", 1),
    )


def agreement_table(estimates: Estimates) -> Table:
    """Returns how far the filters are from the published rows but the first, which is given."""
    rows: list[TableRow] = []
    for table_number in TABLES:
        published = published_table(table_number).estimate_deg
        for name in (PARTICLES, KALMAN):
            off = estimates.angles_deg[table_number, name] - published
            of_seed = np.abs(off[:, 1:]).mean(axis=(1, 2))
            final = off[:, -1].mean(axis=0)
            rows.append(
                {
                    "table": table_number,
                    "filter": name,
                    "n": len(off),
                    "deviation_deg": float(of_seed.mean()),
                    "deviation_p95_deg": float(np.percentile(of_seed, 95)),
                    **_by_axis("final", final),
                    "largest_final_deg": float(np.abs(final).max()),
                }
            )
    return Table.of(
        rows,
        *words("table", "filter", "n"),
        number("mean deviation [deg]", "deviation_deg"),
        number("95 % of seeds below", "deviation_p95_deg"),
        _three("final row, x, y, z", "final", sign="+"),
        number("largest", "largest_final_deg"),
    )


def error_table(estimates: Estimates) -> Table:
    """Returns axis errors from the attitude that was set up: single images, the filter's end."""
    rows: list[TableRow] = []
    for table_number in TABLES:
        table = published_table(table_number)
        single = [_error(table, angles) for angles in table.robot_deg]
        published = _error(table, table.estimate_deg[-1])
        final = estimates.angles_deg[table_number, PARTICLES][:, -1]
        ours = [_error(table, angles) for angles in final]
        mean_axis = unit(np.cos(np.radians(table.robot_deg)).mean(axis=0))
        rows.append(
            {
                "table": table_number,
                "images": len(single),
                "single_mean_deg": float(np.mean(single)),
                "single_best_deg": float(np.min(single)),
                "published_final_deg": published,
                "particles_final_median_deg": float(np.median(ours)),
                "images_below_published": int((np.array(single) < published).sum()),
                "measured_mean_deg": float(axis_error_deg(mean_axis, table.true_axis)),
            }
        )
    return Table.of(
        rows,
        *words("table", "images"),
        number("single image, mean [deg]", "single_mean_deg", 1),
        number("best image", "single_best_deg", 1),
        number("mean of all images", "measured_mean_deg", 1),
        number("filter, published", "published_final_deg", 1),
        number("filter, median of ours", "particles_final_median_deg", 1),
        word("images better than the filter", "images_below_published"),
    )


def conversion_table() -> Table:
    """Returns the published camera columns in the robot's frame, beside the robot columns."""
    rows: list[TableRow] = []
    for table_number in TABLES:
        table = published_table(table_number)
        signed = np.degrees(np.arccos(np.clip(table.converted, -1.0, 1.0)))
        for i, (ours, theirs) in enumerate(zip(signed, table.robot_deg, strict=True), start=1):
            off = folded_deg(ours) - folded_deg(theirs) if table_number == 1 else ours - theirs
            rows.append(
                {
                    "table": table_number,
                    "image": i,
                    **_by_axis("published", theirs),
                    **_by_axis("converted", ours),
                    "folded": table_number == 1,
                    **_by_axis("residual", off),
                    "largest_deg": float(np.abs(off).max()),
                }
            )
    return Table.of(
        rows,
        *words("table", "image"),
        _three("published x, y, z [deg]", "published", digits=0),
        _three("converted, signs kept", "converted", digits=1),
        _three("residual", "residual", sign="+"),
        number("largest", "largest_deg"),
    )


def folding_table(estimates: Estimates) -> Table:
    """Returns the end of Table 1 with signs folded away before the filter, and kept."""
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
            **_by_axis("final", angles),
            "axis_error_deg": _error(table, angles),
            "from_signed_deg": float(angle_between_deg(_axis(angles), kept)),
        }
        for name, angles in finals.items()
    ]
    return Table.of(
        rows,
        *words("input"),
        _three("final x, y, z [deg]", "final"),
        number("axis error", "axis_error_deg", 1),
        number("away from signs kept", "from_signed_deg", 1),
    )


def convention_table(count: int = 4) -> Table:
    """Returns the best readings of the published camera angles."""
    rows: list[TableRow] = [
        {
            "order": reading.order,
            "inverse": reading.is_inverse,
            "camera_axes": reading.camera_axes,
            **{f"table{n}_deg": r for n, r in zip(TABLES, reading.residual_deg, strict=True)},
        }
        for reading in readings()[:count]
    ]
    return Table.of(
        rows,
        word("turns about fixed axes", "order"),
        Column("maps", lambda row: "robot to camera" if row["inverse"] else "camera to robot"),
        word("camera axes", "camera_axes"),
        *(number(f"Table {n}, mean residual [deg]", f"table{n}_deg") for n in TABLES),
    )


def ratio_table() -> Table:
    """Returns the mean deviation of the exact filter from the published rows by its noise ratio."""
    rows: list[TableRow] = []
    for ratio in RATIOS:
        row: TableRow = {"ratio": ratio}
        for table_number in TABLES:
            table = published_table(table_number)
            config = PointFilterConfig(measurement_sigma_cm=1.0, walk_sigma_cm=ratio)
            ours = kalman_estimates(np.cos(np.radians(table.robot_deg)), config)
            off = np.degrees(np.arccos(ours)) - table.estimate_deg
            row[f"table{table_number}_deg"] = float(np.abs(off[1:]).mean())
        rows.append(row)
    return Table.of(
        rows,
        number("q / σ", "ratio"),
        *(number(f"Table {n} [deg]", f"table{n}_deg") for n in TABLES),
    )


def _axis(angles_deg: np.ndarray) -> np.ndarray:
    """Returns the direction of estimated angles; filters leave it not quite of length one."""
    return unit(np.cos(np.radians(angles_deg)))


def _error(table: PublishedTable, angles_deg: np.ndarray) -> float:
    return float(axis_error_deg(_axis(angles_deg), table.true_axis))


def _by_axis(name: str, angles_deg: np.ndarray) -> TableRow:
    """Returns the cells of three angles; None for NaN."""
    values = [None if np.isnan(v) else float(v) for v in angles_deg]
    return {f"{name}_{axis}_deg": value for axis, value in zip(AXES, values, strict=True)}


def _three(label: str, name: str, digits: int = 2, sign: str = "") -> Column:
    """Returns a column that shows the three angles of `_by_axis`."""

    def show(row: TableRow) -> str:
        values: list[float | None] = [row[f"{name}_{axis}_deg"] for axis in AXES]
        shown = [show_number(value, digits, sign=sign) for value in values]
        return "-" if "-" in shown else ", ".join(shown)

    return Column(label, show)
