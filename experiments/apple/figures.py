"""Figures of apples: angles image by image, as in [Zhou2011], and how fast each method learns."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.apple.approach import ERROR_FIELDS, ApproachRow
from experiments.apple.estimates import KALMAN_SIGNED, PARTICLES, Estimates
from experiments.apple.methods import METHODS
from experiments.apple.photographs import SEGMENTED
from experiments.apple.published import TABLES, published_table
from experiments.apple.replay import ReplayRow
from experiments.apple.worlds import CLASSES
from experiments.report.grouping import group_by
from experiments.report.style import (
    PAGE_WIDTH_IN,
    add_legend,
    draw_band,
    figure_style,
    log_scale,
    panel_grid,
    panels,
    write_all,
)
from tracker.apple.view import FruitStatus

STYLES: dict[str, tuple[str, str, str]] = {
    "single-paper": ("#7F7F7F", "x", ":"),
    "single-perspective": ("#B5B5B5", "+", ":"),
    "particle-paper": ("#0072B2", "o", "-"),
    "kalman-paper": ("#56B4E9", "v", "--"),
    "particle-perspective": ("#009E73", "^", "-"),
    "axial": ("#CC79A7", "s", "-"),
    "silhouettes": ("#D55E00", "D", "-"),
}
"""Colour, marker and line of each method."""

MEASURED, PUBLISHED, OURS, SIGNED = "#7F7F7F", "#0072B2", "#D55E00", "#009E73"
FILTER = "filter, published"

_REPLAYED = ("single-paper", "particle-paper", "silhouettes")
_LABELS = {
    "single-paper": "one image, measured",
    "particle-paper": "published filter",
    "silhouettes": "silhouettes",
}


def write_table_figures(folder: Path, estimates: Estimates) -> list[Path]:
    """Writes `table1` and `table2` of the published measurements; returns the paths."""
    with figure_style():
        return write_all(folder, {f"table{n}": draw_table(estimates, n) for n in TABLES})


def draw_table(estimates: Estimates, number: int) -> Figure:
    """Draws each angle over the images: single measurements, both filters, what was set up."""
    table = published_table(number)
    figure, (axes,) = panels(1, 3, 2.6, sharex=True)
    images = np.arange(1, len(table.robot_deg) + 1)
    particles = estimates.angles_deg[number, PARTICLES]
    low, middle, high = np.percentile(particles, [2.5, 50.0, 97.5], axis=0)
    for j, axis in enumerate(axes):
        axis.axhline(table.true_deg[j], color="black", lw=0.9, ls="--", label="set up")
        label = "one image, measured" + (", signs folded" if number == 1 else "")
        axis.plot(images, table.robot_deg[:, j], "x", color=MEASURED, ms=5, label=label)
        if number == 1:
            converted = np.degrees(np.arccos(table.converted[:, j]))
            axis.plot(images, converted, "+", color=SIGNED, ms=6, label="one image, signs kept")
            signed = estimates.mean_deg(number, KALMAN_SIGNED)[:, j]
            axis.plot(images, signed, "-", color=SIGNED, lw=1.0, label="Kalman, signs kept")
        published, label = table.estimate_deg[:, j], f"95 % of {len(particles)} seeds"
        axis.plot(images, published, "o-", color=PUBLISHED, ms=3.5, lw=1.2, label=FILTER)
        draw_band(axis, images, low[:, j], high[:, j], OURS, 0.25, label=label)
        axis.plot(images, middle[:, j], "s-", color=OURS, ms=3, lw=1.0, label="particles, median")
        axis.set_title(f"angle with the robot's {'xyz'[j]} axis [deg]")
        axis.set_xlabel("image")
        axis.set_xticks(images)
    add_legend(figure, axes, columns=4 if number == 1 else 5)
    return figure


def write_replay_figures(folder: Path, rows: Sequence[ReplayRow]) -> list[Path]:
    """Writes `table1` and `table2` of the poses taken again; returns the paths."""
    tables = sorted({row.table for row in rows})
    with figure_style():
        return write_all(folder, {f"table{table}": draw_replay(rows, table) for table in tables})


def draw_replay(rows: Sequence[ReplayRow], table: int) -> Figure:
    """Draws each angle over the images, measured and estimated, as Figs. 3 and 4 of [Zhou2011]."""
    figure, (axes,) = panels(1, 3, 2.5, sharex=True)
    true_deg = published_table(table).true_deg
    for axis, name, truth in zip(axes, "xyz", true_deg, strict=True):
        axis.axhline(truth, color="black", lw=0.9, ls="--", label="set up")
        for method in _REPLAYED:
            _draw_angle(axis, rows, table, method, f"{name}_deg")
        axis.set_title(f"angle with the robot's {name} axis [deg]")
        axis.set_xlabel("image")
        axis.set_xticks(range(1, len(published_table(table).robot_deg) + 1))
    add_legend(figure, axes, columns=4)
    return figure


def _draw_angle(axis: Axes, rows: Sequence[ReplayRow], table: int, method: str, field: str) -> None:
    own = [r for r in rows if (r.table, r.method, r.mask) == (table, method, SEGMENTED)]
    by_image = sorted(group_by(own, ["image"]).items())
    if not all(any(r.status == FruitStatus.FOUND for r in members) for _, members in by_image):
        return
    angles = [[v for r in m if (v := getattr(r, field)) is not None] for _, m in by_image]
    images = [image for (image,), _ in by_image]
    low, middle, high = np.array([np.percentile(of_image, [10, 50, 90]) for of_image in angles]).T
    colour, marker, line = STYLES[method]
    draw_band(axis, images, low, high, colour, 0.18)
    axis.plot(images, middle, marker + line, color=colour, ms=4, lw=1.2, label=_LABELS[method])


def write_approach_figures(folder: Path, rows: Sequence[ApproachRow]) -> list[Path]:
    """Writes `error_by_image` and `error_spread`; returns the paths."""
    chosen = [row for row in rows if row.mask == SEGMENTED]
    with figure_style():
        figures = {"error_by_image": draw_by_image(chosen), "error_spread": draw_spread(chosen)}
        return write_all(folder, figures)


def draw_by_image(rows: Sequence[ApproachRow]) -> Figure:
    """Draws the median error after each image; a panel for each class, a line for each method."""
    groups = _by_class(rows)
    figure, axes = panel_grid(len(groups), 2, PAGE_WIDTH_IN, 2.1)
    images = np.arange(1, len(ERROR_FIELDS) + 1)
    for axis, (fruit_class, members) in zip(axes, groups.items(), strict=True):
        for label, (colour, marker, line), own in _shown(members):
            errors = [[getattr(row, name) for name in ERROR_FIELDS] for row in own]
            curve, size = np.median(errors, axis=0), 3.0 if colour == "black" else 3.5
            axis.plot(images, curve, marker + line, color=colour, ms=size, lw=1.2, label=label)
        count = len({(row.aspect, row.seed) for row in members})
        axis.set_title(f"{fruit_class}, n = {count}")
        log_scale(axis, "y", (0.3, 1.0, 3.0, 10.0, 30.0))
        axis.set_xticks(images)
        axis.set_ylabel("median axis error [deg]")
        axis.set_xlabel("image")
    add_legend(figure, axes, columns=4)
    return figure


def draw_spread(rows: Sequence[ApproachRow]) -> Figure:
    """Draws the share of the worlds in which the error at the end is below a limit."""
    groups = _by_class(rows)
    figure, axes = panel_grid(len(groups), 2, PAGE_WIDTH_IN, 2.0)
    for axis, (fruit_class, members) in zip(axes, groups.items(), strict=True):
        for label, (colour, _, line), own in _shown(members):
            errors, shares = sorted(row.error_deg for row in own), np.arange(1, len(own) + 1)
            axis.step(errors, shares / len(own), where="post", color=colour, ls=line, lw=1.3,
                      label=label)  # fmt: skip
        axis.set_title(fruit_class)
        log_scale(axis, "x", (0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 90.0))
        axis.set_xlim(0.1, 90.0)
        axis.set_ylim(0.0, 1.02)
        axis.set_xlabel("axis error [deg]")
        axis.set_ylabel("share of worlds below")
    add_legend(figure, axes, columns=4)
    return figure


def _by_class(rows: Sequence[ApproachRow]) -> dict[str, list[ApproachRow]]:
    groups = group_by(rows, ["fruit_class"])
    return {name: groups[(name,)] for name in CLASSES if (name,) in groups}


def _shown(
    rows: Sequence[ApproachRow],
) -> Iterator[tuple[str, tuple[str, str, str], list[ApproachRow]]]:
    """Yields label, style and rows of every method, and of the next best views."""
    groups = group_by(rows, ["method", "views"])
    ways = [((method, "arc"), method, STYLES[method]) for method in METHODS]
    next_best = ("silhouettes", "next-best"), "silhouettes, next best view", ("black", "D", "--")
    for key, label, style in (*ways, next_best):
        if key in groups:
            yield label, style, groups[key]
