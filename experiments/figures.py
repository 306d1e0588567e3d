"""Figures rebuilt from the rows of trials.csv and nothing else."""

# Matplotlib leaves the types of its keyword arguments open.
# pyright: reportUnknownMemberType=false

from __future__ import annotations

import zlib
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.config import TrialResult
from experiments.grouping import cell_keys, label
from experiments.tables import Table, TableRow, outcome_table, success_table

# Okabe-Ito colours: they stay apart for colour-blind readers and in grey print.
TRACKER_STYLES: dict[str, tuple[str, str, str]] = {
    "igpf": ("#D55E00", "o", "-"),
    "gpf": ("#0072B2", "s", "-"),
    "pf": ("#009E73", "^", "-"),
    "oracle": ("#000000", "D", "--"),
    "oracle-noisy": ("#7F7F7F", "d", "--"),
    "static": ("#B5B5B5", "v", ":"),
}
"""Colour, marker and line of each tracker, in every figure; control arms are grey and dashed."""

_SPARE_COLOURS = ("#CC79A7", "#56B4E9", "#E69F00", "#8C6D31", "#6A3D9A", "#1B9E77")

OUTCOME_COLOURS = {
    "success": "#3B9B6B",
    "never_detected": "#084594",
    "lost_track": "#4292C6",
    "left_belt": "#9ECAE1",
    "knocked": "#FEC44F",
    "missed": "#FE9929",
    "slipped": "#EC7014",
    "dropped": "#CC4C02",
    "collision": "#CB181D",
    "infeasible_ik": "#6A51A3",
    "timeout": "#969696",
    "error": "#252525",
}
"""Sight in blue, hand in orange, arm in red and violet."""


def tracker_style(name: str) -> tuple[str, str, str]:
    """Colour, marker and line; a tracker without an entry gets a colour by its name."""
    spare = _SPARE_COLOURS[zlib.crc32(name.encode()) % len(_SPARE_COLOURS)]
    return TRACKER_STYLES.get(name, (spare, "P", "-"))


@contextmanager
def figure_style() -> Generator[None, None, None]:
    """The one style of all figures; text in a PDF stays text."""
    style: dict[Any, Any] = {
        "font.size": 9,
        "axes.titlesize": 9,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "axes.axisbelow": True,
        "grid.color": "#E4E4E4",
        "grid.linewidth": 0.6,
        "legend.frameon": False,
        "pdf.fonttype": 42,
        "savefig.dpi": 200,
    }
    with mpl.rc_context({**mpl.rcParamsDefault, "backend": "agg", **style}):
        yield


def write_figures(folder: Path, results: Sequence[TrialResult]) -> list[Path]:
    """Writes the figures into `folder` and returns their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    with figure_style():
        success, outcomes = draw_success(results), draw_outcomes(results)
        paths = [folder / "success_vs_speed.png", folder / "success_vs_speed.pdf"]
        for path in paths:
            save_figure(success, path)
        paths.append(folder / "outcomes.png")
        save_figure(outcomes, paths[-1])
    return paths


def save_figure(figure: Figure, path: Path) -> None:
    """Saves without date and version, so that equal results give equal files."""
    undated = {"CreationDate": None} if path.suffix == ".pdf" else {"Software": None}
    figure.savefig(path, metadata=undated)


def draw_success(results: Sequence[TrialResult]) -> Figure:
    """Success rate against belt speed with Wilson 95 % intervals; a panel for each setting."""
    table, keys = success_table(results), cell_keys(results)
    panels = _panels(table, keys)
    columns = min(3, len(panels))
    rows = -(-len(panels) // columns)
    figure = Figure(figsize=(max(5.2, 3.1 * columns + 1.3), 3.3 * rows), layout="constrained")
    axes: list[Axes] = list(figure.subplots(rows, columns, sharey=True, squeeze=False).flat)
    trackers = list(dict.fromkeys(str(row["tracker"]) for row in table.rows))
    for axis, (title, members) in zip(axes, panels.items(), strict=False):
        _draw_panel(axis, members, trackers)
        axis.set_title(title, loc="left")
    for axis in axes[len(panels) :]:
        axis.set_visible(False)
    axes[0].set_ylabel("successful grasps [%]")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper")
    return figure


def _panels(table: Table, keys: Sequence[str]) -> dict[str, list[TableRow]]:
    """Rows by setting: everything that names a cell except tracker and speed."""
    panels: dict[str, list[TableRow]] = {}
    for row in table.rows:
        setting = [label(key, row[key]) for key in keys if key not in ("tracker", "speed_mps")]
        panels.setdefault(", ".join(setting), []).append(row)
    return panels


def _draw_panel(axis: Axes, rows: Sequence[TableRow], trackers: Sequence[str]) -> None:
    """One line for each tracker; points at one speed stand side by side, not on one another."""
    speeds = [row["speed_mps"] for row in rows]
    step = 0.011 * (max(speeds) - min(speeds) or 1.0)
    for place, tracker in enumerate(trackers):
        members = sorted(
            (row for row in rows if row["tracker"] == tracker), key=lambda row: row["speed_mps"]
        )
        shift = step * (place - 0.5 * (len(trackers) - 1))
        rate = [100 * row["success_rate"] for row in members]
        below = [100 * (row["success_rate"] - row["success_low"]) for row in members]
        above = [100 * (row["success_high"] - row["success_rate"]) for row in members]
        colour, marker, line = tracker_style(tracker)
        axis.errorbar(
            [row["speed_mps"] + shift for row in members],
            rate,
            yerr=[below, above],
            label=tracker,
            color=colour,
            marker=marker,
            linestyle=line,
            markersize=4.5,
            linewidth=1.3,
            elinewidth=0.9,
            capsize=2.5,
            zorder=3,
        )
    axis.set_ylim(-3, 103)
    axis.set_xlim(left=0.0)
    axis.set_xlabel("belt speed [m/s]")


def draw_outcomes(results: Sequence[TrialResult]) -> Figure:
    """How the trials of each cell ended, as one stacked bar a cell."""
    table, keys = outcome_table(results), cell_keys(results)
    names = [key for key in keys if len({row[key] for row in table.rows}) > 1 or key == "tracker"]
    labels = ["  ".join(label(key, row[key]) for key in names) for row in table.rows]
    figure = Figure(figsize=(6.6, 1.1 + 0.24 * len(labels)), layout="constrained")
    axis: Axes = figure.subplots()
    left = [0.0] * len(labels)
    for outcome in (name for name in OUTCOME_COLOURS if name in table.rows[0]):
        share = [100 * row[outcome] / row["n"] for row in table.rows]
        axis.barh(
            range(len(labels)),
            share,
            0.74,
            left,
            color=OUTCOME_COLOURS[outcome],
            label=outcome.replace("_", " "),
        )
        left = [a + b for a, b in zip(left, share, strict=True)]
    axis.set_yticks(range(len(labels)), labels)
    axis.set_ylim(len(labels) - 0.4, -0.6)
    axis.set_xlim(0, 100)
    axis.set_xlabel("trials [%]")
    axis.grid(axis="y", visible=False)
    axis.tick_params(axis="y", length=0)
    figure.legend(loc="outside right upper")
    return figure
