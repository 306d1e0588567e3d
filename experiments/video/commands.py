"""The command `beltgrasp otb`: make sequences, run trackers on them, report."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, TypeAlias

from tyro.conf import Positional, arg, subcommand

from experiments.study.arguments import split_names, worker_count
from experiments.study.exits import CRASH_EXIT, tell_interrupted

# Everything heavy is imported inside the commands, so that --help answers at once.


@dataclass(frozen=True)
class Make:
    """Renders video sequences with exact truth: `beltgrasp otb make --out out/sequences`."""

    out: Annotated[Path, arg(metavar="DIR")]
    """Folder for the sequences; the same command again resumes."""
    only: Annotated[tuple[str, ...], arg(metavar="NAMES")] = ()
    """Sequences or attributes, such as `Door,OCC`; all if not given."""
    seed: int = 0
    """Draws motion, pictures and noise; another seed gives another benchmark of the same kind."""
    workers: Annotated[int | None, arg(metavar="N")] = None
    """Worker processes; one for each processor if not given. The files do not depend on it."""

    def run(self) -> int:
        """Exit code 0."""
        from experiments.belt.rendering import gl_renderer
        from experiments.video.make import make_benchmark

        gl_renderer()
        workers = worker_count(self.workers)
        names = make_benchmark(self.out, split_names(self.only), self.seed, workers)
        print(f"{len(names)} sequence{'s' if len(names) > 1 else ''}: {self.out}")
        return 0


@dataclass(frozen=True)
class Run:
    """Runs trackers on video sequences in OTB layout; the same command again resumes."""

    root: Annotated[Path, arg(metavar="DIR")]
    """Folder of the sequences: NAME/img/ and NAME/groundtruth_rect.txt."""
    out: Annotated[Path, arg(metavar="DIR")]
    """Results folder."""
    trackers: Annotated[tuple[str, ...], arg(metavar="NAMES")] = ("pf", "gpf", "igpf")
    """Video trackers by name (`beltgrasp list`) or import path, with commas or spaces between."""
    protocol: Annotated[tuple[str, ...], arg(metavar="NAMES")] = ("ope",)
    """Any of ope, tre and sre, with commas or spaces between."""
    seeds: Annotated[int, arg(metavar="N")] = 1
    """Random trackers run with the seeds 0 to N - 1, others with 0 alone."""
    only: Annotated[tuple[str, ...], arg(metavar="NAMES")] = ()
    """Sequences or attributes (IV SV OCC DEF MB FM IPR OPR OV BC LR), or TB-50; else all."""
    list: Annotated[Path | None, arg(metavar="FILE")] = None
    """The same from a file, a name a line."""
    workers: Annotated[int | None, arg(metavar="N")] = None
    """Worker processes; one for each processor if not given. The results do not depend on it."""

    def run(self) -> int:
        """Exit code 0, or 1 if anything went wrong: a sequence, a name, a tracker."""
        from experiments.video.run import OtbRun, run_otb
        from experiments.video.selection import read_list

        wanted = [(word, "--only") for word in split_names(self.only)]
        wanted += [] if self.list is None else read_list(self.list)
        request = OtbRun(
            root=self.root,
            trackers=split_names(self.trackers),
            protocols=split_names(self.protocol),
            seed_count=self.seeds,
            wanted=tuple(wanted),
        )
        try:
            done, failures = run_otb(request, self.out, worker_count(self.workers))
        except KeyboardInterrupt:
            return tell_interrupted(self.out)
        print(f"{done} files of boxes: {self.out / 'boxes'}")
        if done:
            print(f"tables and figures: beltgrasp otb report {self.out}")
        return CRASH_EXIT if failures else 0


@dataclass(frozen=True)
class Report:
    """Rebuilds tables and figures of OTB results: `beltgrasp otb report out/otb`."""

    folder: Annotated[Positional[Path], arg(metavar="DIR")]
    """Results folder of `beltgrasp otb run`, finished or not."""
    root: Annotated[Path | None, arg(metavar="DIR")] = None
    """Folder of the sequences; the one that was run if not given."""
    pictures: bool = False
    """Also draws images with the boxes of every tracker."""

    def run(self) -> int:
        """Exit code 0."""
        from experiments.video.report import write_report

        write_report(self.folder, self.root, self.pictures).show()
        return 0


OtbCommand: TypeAlias = (
    Annotated[Make, subcommand("make")]
    | Annotated[Run, subcommand("run")]
    | Annotated[Report, subcommand("report")]
)


@dataclass(frozen=True)
class Otb:
    """Trackers on video sequences by the protocols of OTB: `beltgrasp otb run`."""

    command: OtbCommand

    def run(self) -> int:
        """Exit code of the command."""
        return self.command.run()
