"""Figures of the rendered experiments: angles image by image, and how fast each method learns."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.apple.approach import ERROR_FIELDS, ApproachRow
from experiments.apple.methods import METHODS
from experiments.apple.observer import SEGMENTED
from experiments.apple.published import published_table
from experiments.apple.replay import ReplayRow
from experiments.apple.worlds import CLASSES
from experiments.report.style import (
    PAGE_WIDTH_IN,
    add_legend,
    figure_style,
    panel_grid,
    write_figure,
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

_REPLAYED = ("single-paper", "particle-paper", "silhouettes")
_LABELS = {
    "single-paper": "one image, measured",
    "particle-paper": "published filter",
    "silhouettes": "silhouettes",
}


def write_replay_figures(folder: Path, rows: Sequence[ReplayRow]) -> list[Path]:
    """Writes `table1` and `table2`; returns the paths."""
    with figure_style():
        return [
            path
            for table in sorted({row.table for row in rows})
            for path in write_figure(draw_replay(rows, table), folder, f"table{table}")
        ]


def draw_replay(rows: Sequence[ReplayRow], table: int) -> Figure:
    """Each angle over the images, measured and estimated, as Figs. 3 and 4 of [Zhou2011]."""
    figure = Figure(figsize=(PAGE_WIDTH_IN, 2.5), layout="constrained")
    axes: list[Axes] = list(figure.subplots(1, 3, sharex=True))
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
    images = sorted({row.image for row in own})
    spread = [
        np.percentile(
            [v for row in own if row.image == i and (v := getattr(row, field)) is not None],
            [10, 50, 90],
        )
        for i in images
        if any(row.image == i and row.status == FruitStatus.FOUND for row in own)
    ]
    if len(spread) < len(images):
        return
    low, middle, high = np.array(spread).T
    colour, marker, line = STYLES[method]
    axis.fill_between(images, low, high, color=colour, alpha=0.18, lw=0)
    axis.plot(images, middle, marker + line, color=colour, ms=4, lw=1.2, label=_LABELS[method])


def write_approach_figures(folder: Path, rows: Sequence[ApproachRow]) -> list[Path]:
    """Writes `error_by_image` and `error_spread`; returns the paths."""
    chosen = [row for row in rows if row.mask == SEGMENTED]
    with figure_style():
        paths = write_figure(draw_by_image(chosen), folder, "error_by_image")
        return paths + write_figure(draw_spread(chosen), folder, "error_spread")


def draw_by_image(rows: Sequence[ApproachRow]) -> Figure:
    """Median error after each image; a panel for each class, a line for each method."""
    classes = [name for name in CLASSES if any(row.fruit_class == name for row in rows)]
    figure, axes = panel_grid(len(classes), 2, PAGE_WIDTH_IN, 2.1)
    images = np.arange(1, len(ERROR_FIELDS) + 1)
    for axis, fruit_class in zip(axes, classes, strict=True):
        of_class = [row for row in rows if row.fruit_class == fruit_class]
        for method in METHODS:
            colour, marker, line = STYLES[method]
            curve = _curve(of_class, method, "arc")
            if curve is not None:
                axis.plot(images, curve, marker + line, color=colour, ms=3.5, lw=1.2, label=method)
        curve = _curve(of_class, "silhouettes", "next-best")
        if curve is not None:
            label = "silhouettes, next best view"
            axis.plot(images, curve, "D--", color="black", ms=3, lw=1.2, label=label)
        count = len({(row.aspect, row.seed) for row in of_class})
        axis.set_title(f"{fruit_class}, n = {count}")
        axis.set_yscale("log")
        axis.set_yticks([0.3, 1, 3, 10, 30], ["0.3", "1", "3", "10", "30"])
        axis.minorticks_off()
        axis.set_xticks(images)
        axis.set_ylabel("median axis error [deg]")
        axis.set_xlabel("image")
    add_legend(figure, axes, columns=4)
    return figure


def _curve(rows: Sequence[ApproachRow], method: str, views: str) -> np.ndarray | None:
    own = [row for row in rows if (row.method, row.views) == (method, views)]
    if not own:
        return None
    return np.median([[getattr(row, name) for name in ERROR_FIELDS] for row in own], axis=0)


def draw_spread(rows: Sequence[ApproachRow]) -> Figure:
    """Share of the worlds in which the error at the end is below a limit."""
    classes = [name for name in CLASSES if any(row.fruit_class == name for row in rows)]
    figure, axes = panel_grid(len(classes), 2, PAGE_WIDTH_IN, 2.0)
    for axis, fruit_class in zip(axes, classes, strict=True):
        of_class = [row for row in rows if row.fruit_class == fruit_class]
        for method in METHODS:
            colour, _, line = STYLES[method]
            _draw_shares(axis, of_class, (method, "arc"), (colour, line, method))
        label = "silhouettes, next best view"
        _draw_shares(axis, of_class, ("silhouettes", "next-best"), ("black", "--", label))
        axis.set_title(fruit_class)
        axis.set_xscale("log")
        axis.set_xlim(0.1, 90.0)
        axis.set_xticks([0.1, 0.3, 1, 3, 10, 30, 90], ["0.1", "0.3", "1", "3", "10", "30", "90"])
        axis.minorticks_off()
        axis.set_ylim(0.0, 1.02)
        axis.set_xlabel("axis error [deg]")
        axis.set_ylabel("share of worlds below")
    add_legend(figure, axes, columns=4)
    return figure


def _draw_shares(
    axis: Axes,
    rows: Sequence[ApproachRow],
    chosen: tuple[str, str],
    style: tuple[str, str, str],
) -> None:
    errors = sorted(row.error_deg for row in rows if (row.method, row.views) == chosen)
    if errors:
        colour, line, label = style
        shares = np.arange(1, len(errors) + 1) / len(errors)
        axis.step(errors, shares, where="post", color=colour, ls=line, lw=1.3, label=label)
