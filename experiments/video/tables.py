"""Tables of OTB results: means by protocol, by challenge and by sequence, and affine errors."""

import csv
import math
from collections.abc import Callable, Sequence

import numpy as np

from experiments.report.statistics import bootstrap, mean_ratio, of_known
from experiments.report.table import Column, Table, TableRow, interval, number, show_number, words
from experiments.seeding import Stream, generator
from experiments.video.affine_scores import calibrated
from experiments.video.job import AFFINE_COLUMNS
from experiments.video.results import OtbResults
from experiments.video.scores import Curves, mean_curves
from experiments.video.tb50 import ATTRIBUTES

REFERENCE_TRACKER = "gpf"
"""The tracker over which [IGPF2021] reports its improvement."""

VISIBLE_SHARE = 0.5
"""A frame counts in the affine table if so much of the target can be seen."""

_SCORES: dict[str, Callable[[Curves], float]] = {
    "dp": lambda curves: curves.distance_precision,
    "os": lambda curves: curves.overlap_score,
}
_SCORE_COLUMNS = [number(name.upper(), name, 3) for name in _SCORES]


def score_table(results: OtbResults, score: str) -> Table:
    """Returns means of DP or OS over the sequences, and gains over GPF, by tracker and protocol.

    Tables 1 and 2 of [IGPF2021]; intervals are 95 %, by bootstrap over the sequences.
    """
    protocols = results.protocols
    trackers = dict.fromkeys(t for protocol in protocols for t in results.trackers(protocol))
    rows: list[TableRow] = []
    for tracker in trackers:
        row: TableRow = {"tracker": tracker}
        for protocol in protocols:
            row |= _mean_and_gain(results, protocol, tracker, _SCORES[score])
        rows.append(row)
    columns = words("tracker")
    for protocol in protocols:
        title = f"{score.upper()} {protocol.upper()}, n = {len(results.sequences(protocol))}"
        columns.append(number(title, protocol, 3))
        keys = _gain_keys(protocol)
        label = f"over {REFERENCE_TRACKER} % [95 %]"
        columns.append(interval(label, *keys, digits=1, factor=100.0, sign="+"))
    return Table.of(rows, *columns)


def _mean_and_gain(
    results: OtbResults, protocol: str, tracker: str, score: Callable[[Curves], float]
) -> TableRow:
    sequences, trackers = results.sequences(protocol), results.trackers(protocol)
    row: TableRow = dict.fromkeys((protocol, *_gain_keys(protocol)))
    if tracker not in trackers or not sequences:
        return row
    scores = [score(curves) for curves in results.of(protocol, tracker, sequences)]
    row[protocol] = float(np.mean(scores))
    if REFERENCE_TRACKER in trackers and tracker != REFERENCE_TRACKER:
        of_reference = results.of(protocol, REFERENCE_TRACKER, sequences)
        rng = generator(0, Stream.BOOTSTRAP)
        found = bootstrap(mean_ratio, rng, scores, [score(curves) for curves in of_reference])
        row |= {key: ratio - 1.0 for key, ratio in zip(_gain_keys(protocol), found, strict=True)}
    return row


def _gain_keys(protocol: str) -> tuple[str, str, str]:
    return f"{protocol}_gain", f"{protocol}_gain_low", f"{protocol}_gain_high"


def sequence_table(results: OtbResults) -> Table:
    """Returns DP and OS of every tracker on every sequence that it has finished."""
    rows = [
        {
            "protocol": protocol,
            "sequence": name,
            "tracker": tracker,
            "seeds": len(results.seeds[protocol, tracker, name]),
            **_scores_of(results.curves[protocol, tracker, name]),
        }
        for protocol in results.protocols
        for name in results.names
        for tracker in results.trackers(protocol)
        if (protocol, tracker, name) in results.curves
    ]
    return Table(rows, [*words("protocol", "sequence", "tracker", "seeds"), *_SCORE_COLUMNS])


def attribute_table(results: OtbResults, protocol: str) -> Table:
    """Returns mean DP and OS over the sequences of each challenge that a sequence names."""
    rows = [
        {
            "attribute": attribute,
            "n": len(sequences),
            "tracker": tracker,
            **_scores_of(mean_curves(results.of(protocol, tracker, sequences))),
        }
        for attribute in ATTRIBUTES
        if (sequences := results.sequences(protocol, attribute))
        for tracker in results.trackers(protocol)
    ]
    return Table(rows, [*words("attribute", "n", "tracker"), *_SCORE_COLUMNS])


def _scores_of(curves: Curves) -> TableRow:
    return {name: score(curves) for name, score in _SCORES.items()}


_AFFINE_COLUMNS = (
    ("corner_error_px", "corner [px]", 1.0, 2),
    ("rotation_error_rad", "rotation [deg]", math.degrees(1.0), 2),
    ("scale_error", "scale [%]", 100.0, 1),
    ("aspect_error", "aspect [%]", 100.0, 1),
    ("shear_error", "shear [%]", 100.0, 1),
    ("nees", "NEES (6)", 1.0, 1),
    ("calibrated_nees", "calibrated NEES", 1.0, 1),
    ("ess", "ESS", 1.0, 1),
    ("ancestor_count", "ancestors", 1.0, 1),
    ("resampling_distance", "resampling", 1.0, 3),
)
"""Column of the CSV (one is derived), label, factor and digits for people."""

_HEAVY_TAILED = ("nees", "calibrated_nees", "resampling_distance")
"""A few frames of a lost target rule the mean of these; people see the median, the CSV has both."""


def affine_table(results: OtbResults) -> Table:
    """Returns median and mean of the sizes of the affine errors over all visible frames."""
    rows: list[TableRow] = []
    for protocol in results.protocols:
        for tracker in results.trackers(protocol):
            lines = results.affine_of(protocol, tracker)
            if lines:
                rows.append({"protocol": protocol, "tracker": tracker} | _affine_measures(lines))
    return Table.of(
        rows,
        *words("protocol", "tracker", "frames"),
        *(_median_and_mean(*shown) for shown in _AFFINE_COLUMNS),
    )


def _affine_measures(lines: Sequence[str]) -> TableRow:
    values: dict[str, list[float]] = {key: [] for key, *_ in _AFFINE_COLUMNS}
    # One without values keeps its place, so that all trackers have the same halves.
    nees_of_sequence: dict[str, list[float]] = {}
    count = 0
    for row in csv.DictReader(lines, AFFINE_COLUMNS):
        nees = nees_of_sequence.setdefault(row["sequence"], [])
        if float(row["visible"]) < VISIBLE_SHARE:
            continue
        count += 1
        for key, known in values.items():
            if row.get(key):
                known.append(abs(float(row[key])))
        if row["nees"]:
            nees.append(float(row["nees"]))
    values["calibrated_nees"] = calibrated(nees_of_sequence).tolist()
    measures: TableRow = {"frames": count}
    for key, known in values.items():
        measures[f"median_{key}"] = of_known(np.median, known)
        measures[f"mean_{key}"] = of_known(np.mean, known)
    return measures


def _median_and_mean(key: str, label: str, factor: float, digits: int) -> Column:
    """Returns a column of medians, and of means where they are not ruled by a few frames."""
    names = ["median"] if key in _HEAVY_TAILED else ["median", "mean"]

    def show(row: TableRow) -> str:
        shown = [show_number(row[f"{name}_{key}"], digits, factor) for name in names]
        return "-" if "-" in shown else ", ".join(shown)

    return Column(f"{label} {', '.join(names)}", show)
