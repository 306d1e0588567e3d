"""Precision and success curves of OTB results, as Figs. 4 to 9 of [IGPF2021]."""

from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.report.style import (
    figure_style,
    panel_grid,
    panels,
    save_figure,
    tracker_style,
)
from experiments.video.results import OtbResults
from experiments.video.scores import (
    ERROR_THRESHOLDS_PX,
    OVERLAP_THRESHOLDS,
    Curves,
    mean_curves,
)
from experiments.video.tb50 import ATTRIBUTES

ATTRIBUTE_PROTOCOL = "ope"
"""The protocol whose curves are drawn for each challenge."""
KINDS = ("precision", "success")


def write_figures(folder: Path, results: OtbResults) -> list[Path]:
    """Writes the curves of each protocol, and of each challenge by OPE; returns the paths."""
    figures: dict[str, Figure] = {}
    with figure_style():
        for protocol in results.protocols:
            if results.sequences(protocol):
                figures[f"curves_{protocol}"] = draw_protocol(results, protocol)
        tags = [a for a in ATTRIBUTES if results.sequences(ATTRIBUTE_PROTOCOL, a)]
        if ATTRIBUTE_PROTOCOL in results.protocols and tags:
            for kind in KINDS:
                figures[f"{kind}_by_attribute"] = draw_attributes(results, tags, kind)
        folder.mkdir(parents=True, exist_ok=True)
        paths = [folder / f"{name}.{end}" for name in figures for end in ("png", "pdf")]
        for path in paths:
            save_figure(figures[path.stem], path)
    return paths


def draw_protocol(results: OtbResults, protocol: str) -> Figure:
    """Draws mean precision and success of every tracker over all sequences."""
    figure, (axes,) = panels(1, 2, 3.4)
    sequences = results.sequences(protocol)
    for axis, kind in zip(axes, KINDS, strict=True):
        _draw_panel(axis, results, protocol, sequences, kind)
        axis.set_title(f"{protocol.upper()}, {len(sequences)} sequences", loc="left")
        axis.legend(loc="upper left" if kind == "precision" else "upper right", fontsize=8)
    return figure


def draw_attributes(results: OtbResults, attributes: Sequence[str], kind: str) -> Figure:
    """Draws a panel for each challenge: mean curves over the sequences that have it."""
    figure, axes = panel_grid(len(attributes), 4, 2.6 * min(4, len(attributes)), 2.4)
    for axis, attribute in zip(axes, attributes, strict=True):
        sequences = results.sequences(ATTRIBUTE_PROTOCOL, attribute)
        _draw_panel(axis, results, ATTRIBUTE_PROTOCOL, sequences, kind)
        axis.set_title(f"{ATTRIBUTES[attribute]} ({len(sequences)})", loc="left", fontsize=8)
        axis.legend(loc="upper left" if kind == "precision" else "upper right", fontsize=6)
    return figure


def _draw_panel(
    axis: Axes, results: OtbResults, protocol: str, sequences: Sequence[str], kind: str
) -> None:
    """Draws the trackers, the best first in the legend, with the score that ranks it."""
    curves = {
        tracker: mean_curves(results.of(protocol, tracker, sequences))
        for tracker in results.trackers(protocol)
    }
    for tracker in sorted(curves, key=lambda name: -_score(curves[name], kind)):
        colour, _, line = tracker_style(tracker)
        shares = curves[tracker].precision if kind == "precision" else curves[tracker].success
        axis.plot(
            ERROR_THRESHOLDS_PX if kind == "precision" else OVERLAP_THRESHOLDS,
            shares,
            color=colour,
            linestyle=line,
            linewidth=1.4,
            label=f"{tracker} [{_score(curves[tracker], kind):.3f}]",
        )
    axis.set_ylim(0.0, 1.0)
    axis.set_xlim(0.0, 50.0 if kind == "precision" else 1.0)
    axis.set_xlabel("centre error [px]" if kind == "precision" else "overlap")
    axis.set_ylabel("frames within" if kind == "precision" else "frames above")


def _score(curves: Curves, kind: str) -> float:
    return curves.distance_precision if kind == "precision" else curves.overlap_score
