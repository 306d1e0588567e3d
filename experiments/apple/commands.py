"""The command `beltgrasp apple`: which way apples hang, from published tables and in images."""

from dataclasses import dataclass
from typing import Annotated, TypeAlias

from tyro.conf import arg, subcommand

from experiments.study.command import Plan, StudyCommand, seed_list, split_names

# Everything heavy is imported inside the commands, so that --help answers at once.

_ASPECTS = (0.85, 0.92, 0.95)


@dataclass(frozen=True, kw_only=True)
class Tables(StudyCommand):
    """Repeats Tables 1 and 2 of the paper: `beltgrasp apple tables`."""

    seeds: Annotated[int, arg(metavar="N")] = 100
    """Number of seeds of the particle filter."""
    particle_count: int = 200
    """Particles of the filter."""
    measurement_sigma_cm: float = 5.0
    """Deviation of one image, of a vector of 100 cm."""
    walk_sigma_cm: float = 1.75
    """Deviation of the random walk from one image to the next."""

    def plan(self) -> Plan:
        """All filters on both tables."""
        from dataclasses import asdict

        from experiments.apple.study import get_study
        from tracker.apple.filters import PointFilterConfig

        config = PointFilterConfig(
            self.measurement_sigma_cm, self.walk_sigma_cm, self.particle_count
        )
        seeds = seed_list(self.seeds, self.first_seed)
        return Plan(get_study("apple/tables"), {"filter": asdict(config), "seeds": seeds})


@dataclass(frozen=True, kw_only=True)
class Replay(StudyCommand):
    """Takes the images of the paper's tables again: `beltgrasp apple replay`."""

    seeds: Annotated[int, arg(metavar="N")] = 30
    """Number of seeds: fruits, lights and leaves."""
    tables: tuple[int, ...] = (1, 2)
    """Tables of which the camera poses are taken."""
    aspects: tuple[float, ...] = _ASPECTS
    """Height over diameter of the fruits."""

    def plan(self) -> Plan:
        """Every table with every fruit."""
        from experiments.apple.study import get_study

        seeds = seed_list(self.seeds, self.first_seed)
        selection = {"tables": [*self.tables], "aspects": [*self.aspects], "seeds": seeds}
        return Plan(get_study("apple/replay"), selection)


@dataclass(frozen=True, kw_only=True)
class Approach(StudyCommand):
    """Lets the arm approach fruits and estimate their attitude: `beltgrasp apple approach`."""

    seeds: Annotated[int, arg(metavar="N")] = 30
    """Number of seeds: worlds of each class and aspect."""
    classes: Annotated[tuple[str, ...], arg(metavar="NAMES")] = (
        "visible",
        "hidden",
        "visible-leaves",
        "hidden-leaves",
    )
    """Any of visible, hidden, visible-leaves and hidden-leaves: the calyx, and leaves in front."""
    aspects: tuple[float, ...] = _ASPECTS
    """Height over diameter of the fruits."""
    views: Annotated[tuple[str, ...], arg(metavar="NAMES")] = ("arc",)
    """Ways to choose the camera's places: arc, next-best, or both, compared in the same worlds."""

    def plan(self) -> Plan:
        """Every way to look at every world."""
        from experiments.apple.study import get_study

        selection = {
            "classes": [*split_names(self.classes)],
            "aspects": [*self.aspects],
            "views": [*split_names(self.views)],
            "seeds": seed_list(self.seeds, self.first_seed),
        }
        return Plan(get_study("apple/approach"), selection)


AppleCommand: TypeAlias = (
    Annotated[Tables, subcommand("tables")]
    | Annotated[Replay, subcommand("replay")]
    | Annotated[Approach, subcommand("approach")]
)


@dataclass(frozen=True)
class Apple:
    """Attitude of apples, by one image and by many: `beltgrasp apple tables`."""

    command: AppleCommand

    def run(self) -> int:
        """Exit code of the command."""
        return self.command.run()
