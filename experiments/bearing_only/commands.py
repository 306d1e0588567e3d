"""The command `beltgrasp bearing-only`: fly the studies of [Wu2022], report, film one flight."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

from tyro.conf import Positional, arg, subcommand

from experiments.study.arguments import seed_range, split_names, worker_count
from experiments.study.exits import CRASH_EXIT, tell_interrupted

if TYPE_CHECKING:
    from experiments.bearing_only.config import FlightRun

# Everything heavy is imported inside the commands, so that --help answers at once.


@dataclass(frozen=True)
class _Study:
    """Flies one study; the same command again resumes."""

    out: Annotated[Path, arg(metavar="DIR")]
    """Results folder."""
    controllers: Annotated[tuple[str, ...], arg(metavar="NAMES")] = ()
    """Contestants (`beltgrasp list`), with commas or spaces between; those of the study if none."""
    seeds: Annotated[int, arg(metavar="N")] = 50
    """Seeds 0 to N - 1, the same worlds and noise for every contestant."""
    first_seed: Annotated[int, arg(metavar="N")] = 0
    """Where the seeds begin: tune on others than those that are judged."""
    v_max_mps: Annotated[float | None, arg(metavar="MPS")] = None
    """Speed of the vehicle; that of the study if not given."""
    target_speed_mps: Annotated[float | None, arg(metavar="MPS")] = None
    """Speed of the target; that of the study if not given."""
    landmarks: Annotated[int | None, arg(metavar="N")] = None
    """Landmarks in the room; that of the study if not given."""
    iterations: Annotated[int | None, arg(metavar="N")] = None
    """Length of a flight; that of the study if not given."""
    workers: Annotated[int | None, arg(metavar="N")] = None
    """Worker processes; one for each processor if not given. The results do not depend on it."""
    pixels: bool = False
    """Renders what the camera sees: landmarks are corners, the target is found by CamShift."""
    video: bool = False
    """Also films the first seed of every contestant, into DIR/videos."""

    def run(self) -> int:
        """Exit code 0, or 1 if a flight broke off."""
        from experiments.bearing_only.run import run_flights
        from experiments.study.processes import LocalWorkers, limit_threads

        limit_threads()
        runs, workers = self._runs(), LocalWorkers(worker_count(self.workers))
        try:
            done, failures = run_flights(runs, self.out, workers)
            videos = self._film(runs) if self.video else []
        except KeyboardInterrupt:
            return tell_interrupted(self.out)
        print(f"{done} flights: {self.out / 'runs.csv'}")
        print("".join(f"video: {path}\n" for path in videos), end="")
        print(f"tables and figures: beltgrasp bearing-only report {self.out}")
        return CRASH_EXIT if failures else 0

    def _runs(self) -> list[FlightRun]:
        from experiments.bearing_only.config import PIXELS
        from experiments.bearing_only.studies import STUDIES

        seeds = seed_range(self.seeds, self.first_seed)
        name = type(self).__name__.lower() + (PIXELS if self.pixels else "")
        if name not in STUDIES:
            known = [n.removesuffix(PIXELS) for n in STUDIES if n.endswith(PIXELS)]
            raise ValueError(
                f"--pixels goes with {' and '.join(known)}, not with {type(self).__name__.lower()}"
            )
        if self.pixels and self.landmarks is not None:
            raise ValueError("--landmarks does not go with --pixels: they are corners of the hall")
        study = STUDIES[name]
        given = {
            "v_max_mps": self.v_max_mps,
            "target_speed_mps": self.target_speed_mps,
            "landmark_count": self.landmarks,
            "iteration_count": self.iterations,
        }
        given = {name: value for name, value in given.items() if value is not None}
        runs = study.runs(seeds, split_names(self.controllers))
        replaced = [dataclasses.replace(run, **given) for run in runs]
        return list(dict.fromkeys(replaced))

    def _film(self, runs: list[FlightRun]) -> list[Path]:
        from experiments.bearing_only.film import film

        firsts = {run.controller: run for run in reversed(runs) if run.seed == self.first_seed}
        return [film(run, self.out / "videos") for run in firsts.values()]


class Line(_Study):
    """A target comes head-on: `beltgrasp bearing-only line --out out/line`."""


class Circle(_Study):
    """A target flies a circle: `beltgrasp bearing-only circle --out out/circle`."""


class Speed(_Study):
    """The circle at several speeds of the vehicle."""


class Localisation(_Study):
    """The circle with noise on the known position of the vehicle."""


class Robot(_Study):
    """The indoor robot on two wheels."""


@dataclass(frozen=True)
class Report:
    """Rebuilds tables and figures of a folder: `beltgrasp bearing-only report out/circle`."""

    folder: Annotated[Positional[Path], arg(metavar="DIR")]
    """Results folder of a study, finished or not."""

    def run(self) -> int:
        """Exit code 0."""
        from experiments.bearing_only.report import write_report

        write_report(self.folder).show()
        return 0


BearingOnlyCommand: TypeAlias = (
    Annotated[Line, subcommand("line")]
    | Annotated[Circle, subcommand("circle")]
    | Annotated[Speed, subcommand("speed")]
    | Annotated[Localisation, subcommand("localisation")]
    | Annotated[Robot, subcommand("robot")]
    | Annotated[Report, subcommand("report")]
)


@dataclass(frozen=True)
class BearingOnly:
    """One camera follows a moving target by bearings alone: `beltgrasp bearing-only circle`."""

    command: BearingOnlyCommand

    def run(self) -> int:
        """Exit code of the command."""
        return self.command.run()
