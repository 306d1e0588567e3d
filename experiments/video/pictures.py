"""A strip of images with the boxes of every tracker, as Fig. 3 of [IGPF2021]."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from experiments.report.style import figure_style, save_figure, tracker_style
from experiments.study.manifest import Manifest
from experiments.video.images import SequenceError
from experiments.video.job import VideoJob
from experiments.video.results import OtbResults
from experiments.video.sequences import VideoSequence, find_sequences, load_sequence

SEQUENCE_COUNT, FRAME_COUNT = 4, 5
TRUE_COLOUR = "#FFFFFF"


def write_strip(folder: Path, results: OtbResults) -> list[Path]:
    """Draws some sequences at a few moments, by OPE and the lowest seed.

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
        figure = Figure(figsize=(2.4 * FRAME_COUNT, 1.9 * len(names) + 0.3), layout="constrained")
        axes = figure.subplots(len(names), FRAME_COUNT, squeeze=False)
        for row, sequence in zip(axes, sequences, strict=True):
            _draw_row(list(row), sequence, results)
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
