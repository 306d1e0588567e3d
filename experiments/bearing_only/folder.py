"""A results folder of bearing-only flights: rows as they end, in order when all have ended.

runs.csv, timings.csv and curves.csv.gz are appended to while flights end, the row last: a flight is
done when its row is there. At the end, also after Ctrl-C, they are put into the order of the study,
so that their bytes do not depend on the number of workers or on interruptions.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path

from experiments.bearing_only.config import FlightResult, FlightTimings
from experiments.bearing_only.controllers import CONTROLLERS
from experiments.bearing_only.traces import CURVE_HEADER
from experiments.study import records
from experiments.study.manifest import OTHER_FOLDER
from experiments.study.members import append_member, keep_members, read_members, write_members
from experiments.study.study_folder import claim

KIND = "bearing_only_study"
"""Entry of the manifest that names the study."""
RUNS, TIMINGS, CURVES, TRACES = "runs.csv", "timings.csv", "curves.csv.gz", "traces"
RUNS_HEADER = records.header_line(FlightResult)
TIMINGS_HEADER = records.header_line(FlightTimings)


@dataclass(frozen=True)
class Left:
    """What one flight left, as text."""

    run: str
    timings: str
    curve: str
    crash: str | None = None
    """Traceback of a flight that broke off."""
    traces: tuple[tuple[str, str], ...] = ()
    """File names and contents of a flight that is kept whole."""


def open_folder(out: Path, study: str, workers: int) -> set[str]:
    """Claims a folder for a study or goes on with it; the ids of the flights that are done."""
    claim(out, KIND, study, workers)
    for name, header in ((RUNS, RUNS_HEADER), (TIMINGS, TIMINGS_HEADER)):
        lines = records.whole_lines(out / name, cut=True)
        if not lines:
            records.write_whole(out / name, header)
        elif lines[0] != header:
            raise ValueError(
                f"{out / name} has the columns of another version of beltgrasp; {OTHER_FOLDER}"
            )
    keep_members(out / CURVES, CURVE_HEADER, len(read_members(out / CURVES)))
    return set(_by_id(records.whole_lines(out / RUNS)[1:]))


def append(out: Path, left: Left) -> None:
    """Adds what a flight left; its row comes last."""
    for name, content in left.traces:
        (out / TRACES).mkdir(exist_ok=True)
        records.write_whole(out / TRACES / name, content)
    if left.curve:
        append_member(out / CURVES, left.curve)
    records.append_line(out / TIMINGS, left.timings)
    records.append_line(out / RUNS, left.run)


def put_in_order(out: Path) -> None:
    """Sorts the files of a folder; what has no row is left out."""
    rows = _by_id(records.whole_lines(out / RUNS)[1:])
    timings = _by_id(records.whole_lines(out / TIMINGS)[1:])
    curves = _by_id([member.text for member in read_members(out / CURVES)[1:]])
    ids = sorted(rows, key=lambda run_id: _place(rows[run_id]))
    records.write_whole(out / RUNS, RUNS_HEADER + "".join(rows[i] for i in ids))
    kept = [timings[i] for i in ids if i in timings]
    records.write_whole(out / TIMINGS, TIMINGS_HEADER + "".join(kept))
    write_members(out / CURVES, [CURVE_HEADER, *(curves[i] for i in ids if i in curves)])


def _by_id(texts: Sequence[str]) -> dict[str, str]:
    return {text.partition(",")[0]: text for text in texts}


def _place(line: str) -> tuple[object, ...]:
    """Where a row belongs: by setting, then controller in the order of the registry, then seed."""
    names = [field.name for field in fields(FlightResult)]
    row = dict(zip(names, next(csv.reader([line])), strict=True))
    numbers = ("range_prior", "v_max_mps", "target_speed_mps", "landmark_count", "iteration_count")
    return (
        row["pose_error"],
        *(float(row[name]) for name in (*numbers, "pose_error_m")),
        list(CONTROLLERS).index(row["controller"]),
        int(row["seed"]),
    )


def read_results(out: Path) -> list[FlightResult]:
    """The rows of a folder."""
    return records.read_rows(out / RUNS, FlightResult)
