"""How every figure looks: style, panels, a colour for each tracker, files without a date."""

import re
import zlib
from collections.abc import Generator, Iterable, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal, TypeAlias

import matplotlib as mpl
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, NullLocator

Share: TypeAlias = bool | Literal["none", "all", "row", "col"]
"""Which panels of a figure have a common axis."""

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
    """Returns colour, marker and line; a tracker without an entry gets a colour by its name."""
    spare = _SPARE_COLOURS[zlib.crc32(name.encode()) % len(_SPARE_COLOURS)]
    return TRACKER_STYLES.get(name, (spare, "P", "-"))


@contextmanager
def figure_style() -> Generator[None, None, None]:
    """Sets the one style of all figures; text in a PDF stays text."""
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


def write_all(folder: Path, figures: Mapping[str, Figure]) -> list[Path]:
    """Writes every figure under its name; returns the paths."""
    return [path for name, figure in figures.items() for path in write_figure(figure, folder, name)]


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
    """Adds one legend for all panels, above them, with each label once."""
    labelled: dict[str, Artist] = {}
    for axis in axes:
        for handle, name in zip(*axis.get_legend_handles_labels(), strict=True):
            labelled.setdefault(name, handle)
    figure.legend(list(labelled.values()), list(labelled), loc="outside upper left", ncols=columns)


def panels(
    rows: int,
    columns: int,
    height_in: float,
    width_in: float = PAGE_WIDTH_IN,
    sharex: Share = False,
    sharey: Share = False,
) -> tuple[Figure, list[list[Axes]]]:
    """Returns a figure of that size with equal panels, and the panels row by row."""
    figure = Figure(figsize=(width_in, height_in), layout="constrained")
    grid = figure.subplots(rows, columns, sharex=sharex, sharey=sharey, squeeze=False)
    return figure, [list(row) for row in grid]


def panel_grid(
    panel_count: int, columns: int, width_in: float, row_in: float
) -> tuple[Figure, list[Axes]]:
    """Returns so many panels with common axes; each column has numbers at its foot."""
    columns = min(columns, panel_count)
    rows = -(-panel_count // columns)
    figure, grid = panels(rows, columns, 0.5 + row_in * rows, width_in, True, True)
    axes = [axis for row in grid for axis in row]
    for axis in axes[panel_count:]:
        axis.set_visible(False)
    for axis in axes[max(panel_count - columns, 0) : panel_count]:
        axis.tick_params(labelbottom=True)
    return figure, axes[:panel_count]


def draw_band(
    axis: Axes, x: Any, low: Any, high: Any, colour: str, alpha: float = 0.15, **style: Any
) -> None:
    """Fills the space between two curves with a light colour."""
    axis.fill_between(x, low, high, color=colour, alpha=alpha, linewidth=0, **style)


def log_scale(axes: Axes, name: Literal["x", "y"], ticks: Sequence[float] = ()) -> None:
    """Makes an axis logarithmic, with these ticks, or 1, 2 and 5 of each decade, written out."""
    getattr(axes, f"set_{name}scale")("log")
    axis = axes.xaxis if name == "x" else axes.yaxis
    if ticks:
        axis.set_ticks(ticks, [f"{tick:g}" for tick in ticks])
        axis.set_minor_locator(NullLocator())
        return
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())


def file_name(*parts: str) -> str:
    """Joins the parts to one word that is a file name everywhere."""
    return "_".join(re.sub(r"[^A-Za-z0-9.+-]+", "_", part).strip("_") for part in parts)
