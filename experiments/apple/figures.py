"""Measured against estimated attitudes, as Figs. 3 and 4 of [Zhou2011]."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from experiments.apple.estimates import KALMAN_SIGNED, PARTICLES, Estimates
from experiments.apple.published import TABLES, published_table
from experiments.report.style import add_legend, draw_band, figure_style, panels, write_figure

MEASURED, PUBLISHED, OURS, SIGNED = "#7F7F7F", "#0072B2", "#D55E00", "#009E73"
FILTER = "filter, published"


def write_figures(folder: Path, estimates: Estimates) -> list[Path]:
    """Writes `table1` and `table2`; returns the paths."""
    with figure_style():
        return [
            path
            for number in TABLES
            for path in write_figure(draw_table(estimates, number), folder, f"table{number}")
        ]


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
