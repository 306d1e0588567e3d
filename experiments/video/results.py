"""A folder of OTB results, read back: the curves of every tracker on every sequence."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.study import manifest
from experiments.video import folder
from experiments.video.contestants import CONTESTANTS
from experiments.video.protocols import PROTOCOLS
from experiments.video.scores import Curves, mean_curves, sequence_curves
from experiments.video.sequences import find_sequences, read_attributes, read_boxes
from experiments.video.tracking import BOXES_HEADER


@dataclass(frozen=True, eq=False)
class BoxRun:
    """The boxes of one run, read back from its file."""

    first: int
    """Index of the run's first frame."""
    boxes: np.ndarray
    """(n, 4) x, y, w, h [px], x and y 1-based."""


@dataclass(frozen=True, eq=False)
class OtbResults:
    """What a results folder holds."""

    path: Path
    root: Path
    """Folder of the sequences."""
    truths: dict[str, np.ndarray]
    """Sequence -> true boxes (n, 4)."""
    attributes: dict[str, tuple[str, ...]]
    curves: dict[tuple[str, str, str], Curves]
    """(protocol, tracker, sequence) -> curves, the mean over the seeds."""
    seeds: dict[tuple[str, str, str], tuple[int, ...]]

    @property
    def protocols(self) -> list[str]:
        """Those that were run, in the usual order."""
        found = {protocol for protocol, _, _ in self.curves}
        return [name for name in PROTOCOLS if name in found]

    def trackers(self, protocol: str) -> list[str]:
        """Those that were run by this protocol, in the order of the table of contestants."""
        found = {tracker for name, tracker, _ in self.curves if name == protocol}
        return [*(n for n in CONTESTANTS if n in found), *sorted(found - set(CONTESTANTS))]

    def sequences(self, protocol: str, attribute: str | None = None) -> list[str]:
        """Those that every tracker of the protocol has finished: means are over the same ones."""
        trackers = self.trackers(protocol)
        return [
            name
            for name in self.truths
            if all((protocol, tracker, name) in self.curves for tracker in trackers)
            and (attribute is None or attribute in self.attributes[name])
        ]

    def left_out(self, protocol: str) -> list[str]:
        """Sequences that some trackers of the protocol have finished and others have not."""
        some = {name for found, _, name in self.curves if found == protocol}
        return sorted(some - set(self.sequences(protocol)))

    def of(self, protocol: str, tracker: str, sequences: Sequence[str]) -> list[Curves]:
        """The curves of one tracker on these sequences."""
        return [self.curves[protocol, tracker, name] for name in sequences]


def read_results(path: Path, root: Path | None) -> OtbResults:
    """Reads the boxes in `path` and the ground truth in `root`, by default that of the manifest.

    Raises ValueError where there are no results or they do not fit the ground truth.
    """
    root = root or _root(path)
    found = sorted((path / "boxes").glob("*/*/*/*.csv"))
    if not found:
        raise ValueError(f"{path} holds no finished boxes yet; `beltgrasp otb run` writes them")
    ground_truths = find_sequences(root)
    truths: dict[str, np.ndarray] = {}
    by_seed: dict[tuple[str, str, str], dict[int, Curves]] = {}
    for file in found:
        protocol, tracker, seed, name = *file.relative_to(path / "boxes").parts[:3], file.stem
        if name not in ground_truths:
            raise ValueError(f"{file}: no sequence {name!r} in {root}; give another --root")
        if name not in truths:
            truths[name] = read_boxes(ground_truths[name])
        runs = read_box_file(file, len(truths[name]))
        curves = sequence_curves(
            [run.boxes for run in runs], [truths[name][run.first :] for run in runs]
        )
        by_seed.setdefault((protocol, tracker, name), {})[int(seed)] = curves
    return OtbResults(
        path=path,
        root=root,
        truths={name: truths[name] for name in ground_truths if name in truths},
        attributes={name: read_attributes(name, ground_truths[name].parent) for name in truths},
        curves={key: mean_curves(list(seeds.values())) for key, seeds in by_seed.items()},
        seeds={key: tuple(sorted(seeds)) for key, seeds in by_seed.items()},
    )


def read_box_file(path: Path, frame_count: int) -> list[BoxRun]:
    """The runs of one file, each to the last of the sequence's frames; ValueError if it is not."""
    with path.open(encoding="utf-8", newline="") as file:
        if file.readline() != BOXES_HEADER:
            raise ValueError(f"{path}, line 1: the header must be {BOXES_HEADER.strip()}")
        rows: dict[str, list[list[float]]] = {}
        try:
            for run, *numbers in csv.reader(file):
                rows.setdefault(run, []).append([float(number) for number in numbers])
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from None
    runs: list[BoxRun] = []
    for name, lines in rows.items():
        table = np.array(lines)
        first = int(table[0, 0]) - 1
        if not np.array_equal(table[:, 0], np.arange(first + 1, frame_count + 1)):
            raise ValueError(
                f"{path}: run {name} does not end with frame {frame_count} of the ground truth"
            )
        runs.append(BoxRun(first, table[:, 1:]))
    return runs


def _root(path: Path) -> Path:
    content = manifest.read_manifest(path)
    if content is None or "root" not in content:
        raise ValueError(f"{path} holds no results of `beltgrasp otb run`")
    return folder.root_of(path, content)
