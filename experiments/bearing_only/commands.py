"""The command `beltgrasp bearing-only`: fly the studies of [Wu2022]."""

from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias

from tyro.conf import arg, subcommand

from experiments.study.command import Plan, StudyCommand, seed_list, split_names

# Everything heavy is imported inside the commands, so that --help answers at once.


@dataclass(frozen=True, kw_only=True)
class _Flights(StudyCommand):
    """Flies one study; the same command again resumes."""

    seeds: Annotated[int, arg(metavar="N")] = 50
    """Number of seeds: the same worlds and noise for every controller."""
    controllers: Annotated[tuple[str, ...], arg(metavar="NAMES")] = ()
    """Controllers (`beltgrasp list`), with commas or spaces between; those of the study if none."""
    v_max_mps: Annotated[float | None, arg(metavar="MPS")] = None
    """Speed of the vehicle; that of the study if not given."""
    target_speed_mps: Annotated[float | None, arg(metavar="MPS")] = None
    """Speed of the target; that of the study if not given."""
    landmarks: Annotated[int | None, arg(metavar="N")] = None
    """Landmarks in the room; that of the study if not given."""
    iterations: Annotated[int | None, arg(metavar="N")] = None
    """Length of a flight; that of the study if not given."""
    pixels: bool = False
    """Renders what the camera sees: landmarks are corners, the target is found by CamShift."""

    def plan(self) -> Plan:
        """The study's flights, with the changes that the flags ask for."""
        from experiments.bearing_only.config import PIXELS
        from experiments.bearing_only.studies import STUDIES
        from experiments.bearing_only.study import SUBJECT, get_study

        name = type(self).__name__.lower()
        if self.pixels and name + PIXELS not in STUDIES:
            known = [n.removesuffix(PIXELS) for n in STUDIES if n.endswith(PIXELS)]
            raise ValueError(f"--pixels goes with {' and '.join(known)}, not with {name}")
        if self.pixels and self.landmarks is not None:
            raise ValueError("--landmarks does not go with --pixels: they are corners of the hall")
        given = {
            "v_max_mps": self.v_max_mps,
            "target_speed_mps": self.target_speed_mps,
            "landmark_count": self.landmarks,
            "iteration_count": self.iterations,
        }
        changes = {name: value for name, value in given.items() if value is not None}
        selection: dict[str, Any] = {
            "controllers": [*split_names(self.controllers)],
            "seeds": seed_list(self.seeds, self.first_seed),
        }
        selection |= {"changes": changes} if changes else {}
        study = get_study(f"{SUBJECT}/{name}{PIXELS if self.pixels else ''}")
        return Plan(study, selection)


class Line(_Flights):
    """A target comes head-on: `beltgrasp bearing-only line`."""


class Circle(_Flights):
    """A target flies a circle: `beltgrasp bearing-only circle`."""


class Speed(_Flights):
    """The circle at several speeds of the vehicle."""


class Localisation(_Flights):
    """The circle with noise on the known position of the vehicle."""


class Robot(_Flights):
    """The indoor robot on two wheels."""


BearingOnlyCommand: TypeAlias = (
    Annotated[Line, subcommand("line")]
    | Annotated[Circle, subcommand("circle")]
    | Annotated[Speed, subcommand("speed")]
    | Annotated[Localisation, subcommand("localisation")]
    | Annotated[Robot, subcommand("robot")]
)


@dataclass(frozen=True)
class BearingOnly:
    """One camera follows a moving target by bearings alone: `beltgrasp bearing-only circle`."""

    command: BearingOnlyCommand

    def run(self) -> int:
        """Exit code of the command."""
        return self.command.run()
