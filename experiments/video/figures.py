"""Curves of OTB results and boxes on images, as Figs. 3 to 9 of [IGPF2021]."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from experiments.report.style import (
    figure_style,
    panel_grid,
    panels,
    save_figure,
    tracker_style,
    write_all,
)
from experiments.study.manifest import Manifest
from experiments.video.job import VideoJob
from experiments.video.results import OtbResults
from experiments.video.scores import ERROR_THRESHOLDS_PX, OVERLAP_THRESHOLDS, Curves, mean_curves
from experiments.video.sequences import SequenceError, VideoSequence, find_sequences, load_sequence
from experiments.video.tb50 import ATTRIBUTES

ATTRIBUTE_PROTOCOL = "ope"
"""The protocol whose curves are drawn for each challenge."""
KINDS = ("precision", "success")
SEQUENCE_COUNT, FRAME_COUNT = 4, 5
"""Rows and columns of the strip of images."""
TRUE_COLOUR = "#FFFFFF"


def write_figures(folder: Path, results: OtbResults) -> list[Path]:
    """Writes the curves of each protocol, those of each challenge by OPE, and a strip of images."""
    figures: dict[str, Figure] = {}
    with figure_style():
        for protocol in results.protocols:
            if results.sequences(protocol):
                figures[f"curves_{protocol}"] = draw_protocol(results, protocol)
        tags = [a for a in ATTRIBUTES if results.sequences(ATTRIBUTE_PROTOCOL, a)]
        if ATTRIBUTE_PROTOCOL in results.protocols and tags:
            for kind in KINDS:
                figures[f"{kind}_by_attribute"] = draw_attributes(results, tags, kind)
        return write_all(folder, figures) + write_strip(folder, results)


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


def write_strip(folder: Path, results: OtbResults) -> list[Path]:
    """Draws some sequences with the boxes of every tracker at a few moments, by the lowest seed.

    There is none without OPE, boxes, or the images of the sequences.
    """
    names, root = _spread(results.sequences("ope")), _root_of(results.path)
    if not (names and root.is_dir() and (results.path / "boxes").is_dir()):
        return []
    try:
        found = find_sequences(root)
        sequences = [load_sequence(name, found[name]) for name in names]
    except (KeyError, SequenceError):
        return []
    trackers = results.trackers("ope")
    with figure_style():
        figure, axes = panels(len(names), FRAME_COUNT, 1.9 * len(names) + 0.3, 2.4 * FRAME_COUNT)
        for row, sequence in zip(axes, sequences, strict=True):
            _draw_row(row, sequence, results)
        handles = [Line2D([], [], color=tracker_style(t)[0], label=t) for t in trackers]
        handles.append(Line2D([], [], color="#888888", linestyle=":", label="truth"))
        figure.legend(handles=handles, loc="outside upper center", ncols=len(handles))
        folder.mkdir(parents=True, exist_ok=True)
        save_figure(figure, folder / "boxes_ope.png")
    return [folder / "boxes_ope.png"]


def _root_of(folder: Path) -> Path:
    """The folder of sequences that the results are of."""
    manifest = Manifest.read(folder)
    return Path(manifest.selections[0]["root"] if manifest is not None else "")


def _spread(names: list[str]) -> list[str]:
    """Returns a few of the names, spread over the list."""
    places = np.linspace(0, len(names) - 1, min(SEQUENCE_COUNT, len(names))).round()
    return [names[int(place)] for place in places]


def _draw_row(axes: list[Axes], sequence: VideoSequence, results: OtbResults) -> None:
    boxes: dict[str, np.ndarray] = {}
    for tracker in results.trackers("ope"):
        seed = results.seeds["ope", tracker, sequence.name][0]
        job = VideoJob("ope", sequence.name, tracker, seed, "")
        table = np.loadtxt(results.path / job.boxes_path, delimiter=",", skiprows=1, ndmin=2)
        boxes[tracker] = table[:, 2:]
    for axis, place in zip(axes, np.linspace(0, len(sequence) - 1, len(axes)), strict=True):
        index = round(place)
        axis.imshow(sequence.image(index)[..., ::-1])
        for tracker, found in boxes.items():
            _draw_box(axis, found[index], tracker_style(tracker)[0], "-")
        _draw_box(axis, sequence.boxes[index], TRUE_COLOUR, ":")
        axis.set_xlim(-0.5, sequence.size_px[0] - 0.5)
        axis.set_ylim(sequence.size_px[1] - 0.5, -0.5)
        axis.set_axis_off()
        axis.set_title(f"{sequence.name} #{index + 1}", loc="left", fontsize=8)


def _draw_box(axis: Axes, box: np.ndarray, colour: str, line: str) -> None:
    if not (np.isfinite(box).all() and (box[2:] > 0).all()):
        return
    x, y, w, h = (float(value) for value in box)
    edge = Rectangle((x - 1.5, y - 1.5), w, h, fill=False, color=colour, linestyle=line)
    axis.add_patch(edge)
