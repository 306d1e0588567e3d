"""The command `beltgrasp apple`: attitude of apples, from published tables and in images."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, TypeAlias

from tyro.conf import Positional, arg, subcommand

from experiments.apple.rendered_commands import Approach, Replay
from experiments.study.arguments import seed_range

# Everything heavy is imported inside the commands, so that --help answers at once.


@dataclass(frozen=True)
class Tables:
    """Repeats Tables 1 and 2 of the paper: `beltgrasp apple tables --out out/apple-tables`."""

    out: Annotated[Path, arg(metavar="DIR")]
    """Results folder: the rows, tables and figures; the same command again rewrites them."""
    seeds: Annotated[int, arg(metavar="N")] = 100
    """The particle filter runs with the seeds 0 to N - 1."""
    particle_count: int = 200
    """Particles of the filter."""
    measurement_sigma_cm: float = 5.0
    """Deviation of one image, of a vector of 100 cm."""
    walk_sigma_cm: float = 1.75
    """Deviation of the random walk from one image to the next."""

    def run(self) -> int:
        """Exit code 0."""
        from dataclasses import asdict

        from experiments.apple.estimates import estimate_rows, write_estimates
        from experiments.apple.report import write_report
        from experiments.study.results_folder import exclusive
        from experiments.study.study_folder import claim
        from tracker.apple.filters import PointFilterConfig

        config = PointFilterConfig(
            self.measurement_sigma_cm, self.walk_sigma_cm, self.particle_count
        )
        seeds = len(seed_range(self.seeds))
        with exclusive(self.out):
            claim(self.out, "apple", "tables", 1, {"seeds": seeds, **asdict(config)})
            path = write_estimates(self.out, estimate_rows(config, seeds))
            report = write_report(self.out)
        report.show()
        print(f"rows: {path}")
        return 0


@dataclass(frozen=True)
class Report:
    """Rebuilds tables and figures of apple results: `beltgrasp apple report out/apple-tables`."""

    folder: Annotated[Positional[Path], arg(metavar="DIR")]
    """Results folder of any command of `beltgrasp apple`."""

    def run(self) -> int:
        """Exit code 0."""
        from experiments.apple.report import write_report

        write_report(self.folder).show()
        return 0


AppleCommand: TypeAlias = (
    Annotated[Tables, subcommand("tables")]
    | Annotated[Replay, subcommand("replay")]
    | Annotated[Approach, subcommand("approach")]
    | Annotated[Report, subcommand("report")]
)


@dataclass(frozen=True)
class Apple:
    """Attitude of apples, by one image and by many: `beltgrasp apple tables`."""

    command: AppleCommand

    def run(self) -> int:
        """Exit code of the command."""
        return self.command.run()
