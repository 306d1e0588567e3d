"""What the work of a flight leaves: row, timings, curve and, of a few, the whole flight."""

import time
import traceback
from collections.abc import Sequence

import numpy as np

from experiments.bearing_only.config import FlightResult, FlightRun, FlightTimings
from experiments.bearing_only.flying import Flown, fly
from experiments.bearing_only.scores import results_of
from experiments.bearing_only.traces import (
    CURVES,
    TRACES,
    curve_of,
    is_traced,
    map_of,
    trace_name,
    trace_of,
)
from experiments.study.provenance import code_version
from experiments.study.study import Result


def fly_runs(runs: Sequence[FlightRun]) -> list[Result[FlightResult]]:
    """Flies one run, or several of an oracle's at once; a result for each.

    A flight whose pilot broke off has a row with `outcome` error and the traceback.
    """
    started_s = time.perf_counter()
    flown = fly(runs)
    rows = results_of(runs, flown, str(code_version()))
    wall_s = time.perf_counter() - started_s
    step_ms = 1e3 * np.array(flown.log.step_s or [np.nan])
    median_ms, p95_ms = float(np.median(step_ms)), float(np.percentile(step_ms, 95))
    error = None
    if flown.error is not None:
        error = "".join(traceback.format_exception(flown.error))
    return [
        Result(
            rows=(row,),
            timings=FlightTimings(run.run_id, run.controller, median_ms, p95_ms, len(runs), wall_s),
            curves={CURVES: curve_of(run, flown.log, index)},
            files=_traces(run, flown, index),
            error=error,
        )
        for index, (run, row) in enumerate(zip(runs, rows, strict=True))
    ]


def _traces(run: FlightRun, flown: Flown, index: int) -> dict[str, str]:
    """Path -> CSV of a flight that is kept whole; none of others."""
    if not (is_traced(run) and flown.log.is_seen):
        return {}
    name = f"{TRACES}/{trace_name(run)}"
    traces = {f"{name}.csv": trace_of(flown.log, index)}
    landmarks = map_of(flown)
    return traces if landmarks is None else traces | {f"{name}_map.csv": landmarks}
