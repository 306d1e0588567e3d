"""The studies of bearing-only tracking as the mechanism runs them: one flight a job."""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from typing import Any

from experiments.bearing_only.config import FlightResult, FlightRun, FlightTimings
from experiments.bearing_only.controllers import CONTROLLERS, ORACLES, get_controller
from experiments.bearing_only.studies import STUDIES
from experiments.bearing_only.traces import CURVE_HEADER, CURVES
from experiments.study.study import Score, Selection, Study
from tracker.checks import require_known

SUBJECT = "bearing-only"


def get_study(name: str) -> Study[FlightRun, FlightResult]:
    """The study `bearing-only/STUDY`; ValueError that lists the known ones for another."""
    study = name.removeprefix(f"{SUBJECT}/")
    require_known("study", study, STUDIES)
    return Study(
        name=f"{SUBJECT}/{study}",
        unit="flight",
        row=FlightResult,
        key=("run_id",),
        jobs=partial(flights, study),
        work="experiments.bearing_only.run:fly_runs",
        settings=flight_settings,
        report="experiments.bearing_only.report:write_report",
        title=describe_flight,
        method="controller",
        score=Score(target_error, "mean error of the target [m]", higher_is_better=False),
        order=place_of,
        identity=known_columns,
        timings=FlightTimings,
        curves={CURVES: CURVE_HEADER},
        together=oracle_cell,
        needs_rendering=STUDIES[study].base.is_rendered,
        is_failure=is_failure,
        film="experiments.bearing_only.film:film",
    )


def flights(study: str, selection: Selection) -> list[FlightRun]:
    """All flights of a selection: by setting, controller and seed."""
    return STUDIES[study].runs(
        selection["seeds"], selection["controllers"], selection.get("changes")
    )


def flight_settings(run: FlightRun) -> Mapping[str, object]:
    """The world of a flight, the settings of its controller, and those of its pilot and map."""
    from experiments.bearing_only.pilots import pilot_config, slam_config
    from experiments.bearing_only.studies import world_of

    world = asdict(world_of(run))
    for name in ("iteration_count", "landmark_count"):  # these are fields of the run
        world.pop(name)
    world["target"].pop("velocity_mps")
    pilot = asdict(pilot_config(run))
    pilot["control"].pop("v_max_mps")
    return {
        "world": world,
        f"controller {run.controller}": get_controller(run.controller),
        f"pilot {run.controller}": pilot,
        "map": slam_config(run),
    }


def oracle_cell(run: FlightRun) -> Hashable:
    """Flights of an oracle that differ in their seed alone are flown at once; None for others."""
    if get_controller(run.controller).pose not in ORACLES:
        return None
    return run.controller, run.v_max_mps, run.range_prior, run.pose_error, run.pose_error_m


def describe_flight(run: FlightRun) -> str:
    """Study, controller and seed, with what may vary in between."""
    error = f", pose error {run.pose_error} {run.pose_error_m:g} m" * (run.pose_error != "none")
    return (
        f"{run.study}, {run.controller}, prior {run.range_prior:g}, {run.v_max_mps:g} m/s{error}, "
        f"seed {run.seed}"
    )


def place_of(run: FlightRun) -> Any:
    """By setting, then controller in the order of the registry, then seed."""
    return (
        run.pose_error,
        run.range_prior,
        run.v_max_mps,
        run.target_speed_mps,
        run.landmark_count,
        run.iteration_count,
        run.pose_error_m,
        list(CONTROLLERS).index(run.controller),
        run.seed,
    )


def known_columns(run: FlightRun) -> dict[str, Any]:
    """The columns of a row that are known before the flight."""
    return {"run_id": run.run_id, **asdict(run), "flights_at_once": 1}


def is_failure(rows: Sequence[FlightResult]) -> bool:
    """Whether the target was not followed to the end."""
    return rows[0].outcome != "tracked"


def target_error(row: FlightResult) -> tuple[Any, float] | None:
    """What a flight met, and its mean error of the target; None where it broke off."""
    if row.target_error_m is None:
        return None
    names = ("range_prior", "v_max_mps", "target_speed_mps", "landmark_count", "iteration_count")
    met = (*(getattr(row, name) for name in names), row.pose_error, row.pose_error_m, row.seed)
    return met, row.target_error_m
