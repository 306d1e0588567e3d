"""Sweeps as a study: every cell at every seed, one attempt to grasp each."""

import dataclasses
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from experiments.belt.analysis.cells import SETTING
from experiments.belt.config import TrialConfig, TrialResult, TrialTimings
from experiments.belt.curves import CURVE_HEADER, CURVES
from experiments.belt.presets import Preset
from experiments.study.settings import digest
from experiments.study.study import Score, Selection, Study
from tracker.checks import require_known

SUBJECT = "belt"
SINGLE = "trial"
"""Name of the study that a single attempt belongs to."""


@dataclasses.dataclass(frozen=True)
class SweepTrial:
    """One attempt of a sweep."""

    preset: str
    config: TrialConfig
    video_path: Path | None = None
    """Where to write a video of it, if anywhere."""


def get_study(name: str) -> Study[SweepTrial, TrialResult]:
    """The sweep `belt/PRESET`, also of a preset that has another name than those known."""
    preset = name.removeprefix(f"{SUBJECT}/")
    return Study(
        name=name,
        unit="trial",
        row=TrialResult,
        key=("trial_id",),
        jobs=partial(trials, preset),
        work="experiments.belt.trial:run_trials",
        settings=trial_settings,
        report="experiments.belt.report:write_report",
        title=describe_trial,
        method="tracker",
        score=Score(success_of_world, "success", higher_is_better=True),
        compare="experiments.belt.analysis.comparison:verdict_lines",
        order=seed_of,
        identity=known_columns,
        timings=TrialTimings,
        curves={CURVES: CURVE_HEADER},
        needs_rendering=True,
        is_failure=is_failure,
        film="experiments.belt.trial:film_trial",
    )


def selection_of(cells: Sequence[TrialConfig], seeds: Sequence[int]) -> Selection:
    """What the manifest keeps of a sweep: where its cells differ from a trial's defaults."""
    standard = dataclasses.asdict(TrialConfig())
    told = [
        {k: v for k, v in dataclasses.asdict(cell).items() if k != "seed" and v != standard[k]}
        for cell in cells
    ]
    return {"cells": told, "seeds": list(seeds)}


def trials(preset: str, selection: Selection) -> list[SweepTrial]:
    """Every trial of a selection: all seeds of a cell, then the next cell."""
    cells = tuple(TrialConfig(**cell) for cell in selection["cells"])
    Preset(preset, "", cells, tuple(selection["seeds"]))  # complains of what repeats
    return [
        SweepTrial(preset, dataclasses.replace(cell, seed=seed))
        for cell in cells
        for seed in selection["seeds"]
    ]


def trial_settings(job: SweepTrial) -> Mapping[str, object]:
    """The registered things that a trial names, with the files that they are made of.

    Raises ValueError for a name that no registry holds.
    """
    from sim import ASSETS
    from sim.arm.embodiments import get_embodiment
    from sim.belt.objects import get_object
    from sim.belt.scenario import MOTIONS
    from sim.imaging.camera import get_view
    from sim.imaging.degradations import get_condition
    from tracker.belt.prediction import PREDICTORS

    config = job.config
    graspable = get_object(config.object)
    require_known("motion", config.motion, MOTIONS)
    require_known("predictor", config.predictor, PREDICTORS)
    return {
        f"tracker {config.tracker}": tracker_settings(config.tracker),
        f"embodiment {config.embodiment}": get_embodiment(config.embodiment),
        f"camera {config.camera}": get_view(config.camera),
        f"condition {config.condition}": get_condition(config.condition),
        f"object {config.object}": {"spec": graspable, "model": ASSETS / graspable.xml},
        f"motion {config.motion}": MOTIONS[config.motion],
        f"predictor {config.predictor}": PREDICTORS[config.predictor],
    }


def tracker_settings(name: str) -> object:
    """The settings of a tracker or control arm and, of a tracker from outside, its source.

    Raises ValueError for a name that there is not, and for a peer that is not installed.
    """
    from experiments.belt.perception import CONTROL_ARMS
    from tracker.belt.registry import PEERS, TRACKERS, get_tracker_config
    from tracker.peers.outside import get_box_finder, is_outside, outside_source

    if is_outside(name):
        get_box_finder(name)
        return {"source": digest(outside_source(name).encode())}
    require_known("tracker", name, [*TRACKERS, *CONTROL_ARMS, *PEERS])
    if name in PEERS:
        get_box_finder(name).require_available()
    return CONTROL_ARMS.get(name) or get_tracker_config(name)


def known_columns(job: SweepTrial) -> dict[str, Any]:
    """The columns of a row that are known before the trial has run."""
    known = dataclasses.asdict(job.config)
    return {**known, "trial_id": job.config.trial_id, "preset": job.preset}


def describe_trial(job: SweepTrial) -> str:
    """Tracker, speed, condition and seed."""
    c = job.config
    return f"{c.tracker} at {c.speed_mps:g} m/s, {c.condition}, seed {c.seed}"


def seed_of(job: SweepTrial) -> int:
    """Rows stand by seed: stopped early, a sweep leaves the same worlds in every cell."""
    return job.config.seed


def is_failure(rows: Sequence[TrialResult]) -> bool:
    """Whether the object was not lifted and held."""
    return not rows[0].success


def success_of_world(row: TrialResult) -> tuple[tuple[Any, ...], float]:
    """The world that a trial met, and 1 for a success."""
    return (*(getattr(row, name) for name in SETTING), row.seed), float(row.success)
