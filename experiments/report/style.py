"""How every figure looks: one style, a colour for each tracker, and files without a date."""

from __future__ import annotations

import re
import zlib
from collections.abc import Generator, Iterable, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.belt.config import TrialResult
from experiments.report.grouping import cell_keys, group_by, label

PAGE_WIDTH_IN = 7.2
"""Width of a figure across both columns of a paper [inch]."""

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


def tracker_style(name: str) -> tuple[str, str, str]:
    """Colour, marker and line; a tracker without an entry gets a colour by its name."""
    spare = _SPARE_COLOURS[zlib.crc32(name.encode()) % len(_SPARE_COLOURS)]
    return TRACKER_STYLES.get(name, (spare, "P", "-"))


@contextmanager
def figure_style() -> Generator[None, None, None]:
    """The one style of all figures; text in a PDF stays text."""
    style: dict[Any, Any] = {
        "font.size": 8,
        "axes.titlesize": 8,
        "axes.titlelocation": "left",
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


def write_figure(figure: Figure, folder: Path, name: str) -> list[Path]:
    """Writes NAME.png and NAME.pdf; returns the paths."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{name}.{end}" for end in ("png", "pdf")]
    for path in paths:
        save_figure(figure, path)
        figure.set_layout_engine("none")  # laid out once, for both: it takes most of the time
    return paths


def save_figure(figure: Figure, path: Path) -> None:
    """Saves without date and version, so that equal results give equal files."""
    undated = {"CreationDate": None} if path.suffix == ".pdf" else {"Software": None}
    figure.savefig(path, metadata=undated)


def add_legend(figure: Figure, axes: Iterable[Axes], columns: int) -> None:
    """One legend for all panels, above them: each label once."""
    labelled: dict[str, Artist] = {}
    for axis in axes:
        for handle, name in zip(*axis.get_legend_handles_labels(), strict=True):
            labelled.setdefault(name, handle)
    figure.legend(list(labelled.values()), list(labelled), loc="outside upper left", ncols=columns)


def panel_grid(
    panel_count: int, columns: int, width_in: float, row_in: float
) -> tuple[Figure, list[Axes]]:
    """A figure of so many equal panels with common axes; each column has numbers at its foot."""
    columns = min(columns, panel_count)
    rows = -(-panel_count // columns)
    figure = Figure(figsize=(width_in, 0.5 + row_in * rows), layout="constrained")
    axes: list[Axes] = list(
        figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).flat
    )
    for axis in axes[panel_count:]:
        axis.set_visible(False)
    for axis in axes[max(panel_count - columns, 0) : panel_count]:
        axis.tick_params(labelbottom=True)
    return figure, axes[:panel_count]


def settings_of(
    results: Sequence[TrialResult], keys: Sequence[str]
) -> dict[str, list[TrialResult]]:
    """Results by everything that names a cell except tracker and speed, under a title.

    The title names what varies; all of it where nothing does.
    """
    names = [key for key in keys if key not in ("tracker", "speed_mps")]
    varying = [key for key in names if len({getattr(row, key) for row in results}) > 1]
    return {
        ", ".join(
            label(key, value)
            for key, value in zip(names, setting, strict=True)
            if key in varying or not varying
        ): members
        for setting, members in group_by(results, names).items()
    }


def trackers_of(results: Sequence[TrialResult]) -> list[str]:
    """The trackers in order of first appearance."""
    return list(dict.fromkeys(row.tracker for row in results))


def cell_sizes(results: Sequence[TrialResult]) -> str:
    """The number of trials behind each value of a figure, in words."""
    sizes = {len(members) for members in group_by(results, cell_keys(results)).values()}
    return f"n = {min(sizes)}" + (f" to {max(sizes)}" if len(sizes) > 1 else "")


def file_name(*parts: str) -> str:
    """The parts as one word that is a file name everywhere."""
    return "_".join(re.sub(r"[^A-Za-z0-9.+-]+", "_", part).strip("_") for part in parts)
