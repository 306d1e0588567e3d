"""The command `beltgrasp otb`: render sequences, and run trackers on sequences."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, TypeAlias

from tyro.conf import arg, subcommand

from experiments.study.command import Plan, StudyCommand, seed_list, split_names

# Everything heavy is imported inside the commands, so that --help answers at once.


@dataclass(frozen=True, kw_only=True)
class Make(StudyCommand):
    """Renders video sequences with exact truth: `beltgrasp otb make --out out/sequences`."""

    only: Annotated[tuple[str, ...], arg(metavar="NAMES")] = ()
    """Sequences or attributes, such as `Door,OCC`; all if not given."""
    seed: int = 0
    """Draws motion, pictures and noise; another seed gives another benchmark of the same kind."""

    def plan(self) -> Plan:
        """The sequences of the benchmark that are asked for."""
        from experiments.video.clips import RECIPES
        from experiments.video.selection import select
        from experiments.video.study import get_study

        if self.seeds is not None or self.first_seed:
            raise ValueError("a benchmark of sequences has one seed: give --seed")
        tags = {name: recipe.attributes for name, recipe in RECIPES.items()}
        wanted = [(name, "--only") for name in split_names(self.only)]
        names, complaints = select(tags, wanted) if wanted else (list(RECIPES), [])
        if complaints:
            raise ValueError("; ".join(complaints))
        return Plan(get_study("video/sequences"), {"names": names, "seed": self.seed})

    def run(self) -> int:
        """Exit code 0, or 1 if a sequence could not be made; writes the folder's README too."""
        from experiments.studies import rebuild_report

        code = super().run()
        if code == 0 and self.shard is None:
            rebuild_report(self.folder)
        return code


@dataclass(frozen=True, kw_only=True)
class Run(StudyCommand):
    """Runs trackers on video sequences in OTB layout; the same command again resumes."""

    root: Annotated[Path, arg(metavar="DIR")]
    """Folder of the sequences: NAME/img/ and NAME/groundtruth_rect.txt."""
    trackers: Annotated[tuple[str, ...], arg(metavar="NAMES")] = ("pf", "gpf", "igpf")
    """Video trackers by name (`beltgrasp list`) or import path, with commas or spaces between."""
    protocol: Annotated[tuple[str, ...], arg(metavar="NAMES")] = ("ope",)
    """Any of ope, tre and sre, with commas or spaces between."""
    seeds: Annotated[int, arg(metavar="N")] = 1
    """Number of seeds of random trackers; others run once."""
    only: Annotated[tuple[str, ...], arg(metavar="NAMES")] = ()
    """Sequences or attributes (IV SV OCC DEF MB FM IPR OPR OV BC LR), or TB-50; else all."""
    list: Annotated[Path | None, arg(metavar="FILE")] = None
    """The same from a file, a name a line."""

    def plan(self) -> Plan:
        """The trackers on the sequences that can be used; a complaint about each other one."""
        from experiments.video.protocols import PROTOCOLS
        from experiments.video.selection import read_list, usable_sequences
        from experiments.video.study import get_study
        from tracker.checks import require_known

        protocols = [*split_names(self.protocol)]
        for name in protocols:
            require_known("protocol", name, PROTOCOLS)
        wanted = [(word, "--only") for word in split_names(self.only)]
        wanted += [] if self.list is None else read_list(self.list)
        names, complaints = usable_sequences(self.root, wanted, protocols)
        selection = {
            "root": str(self.root),
            "protocols": protocols,
            "trackers": [*split_names(self.trackers)],
            "sequences": names,
            "seeds": seed_list(self.seeds, self.first_seed),
        }
        return Plan(get_study("video/otb"), selection, tuple(complaints))


OtbCommand: TypeAlias = Annotated[Make, subcommand("make")] | Annotated[Run, subcommand("run")]


@dataclass(frozen=True)
class Otb:
    """Trackers on video sequences by the protocols of OTB: `beltgrasp otb run`."""

    command: OtbCommand

    def run(self) -> int:
        """Exit code of the command."""
        return self.command.run()
