"""The command `beltgrasp`: studies of four subjects, and what all results folders have."""

import contextlib
import difflib
import io
import itertools
import os
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, TypeAlias

import tyro
from tyro.conf import Positional, arg, subcommand

from experiments.apple.commands import Apple
from experiments.bearing_only.commands import BearingOnly
from experiments.belt.commands import Sweep, Trial, View
from experiments.study.command import INTERRUPT_EXIT, USAGE_EXIT
from experiments.study.provenance import code_version, package_version
from experiments.video.commands import Otb

# Everything heavy is imported inside the commands, so that --help answers at once.


@dataclass(frozen=True)
class Report:
    """Rebuilds the tables and figures of a results folder: `beltgrasp report out/demo`."""

    folder: Annotated[Positional[Path], arg(metavar="DIR")]
    """Results folder of any study, finished or not."""

    def run(self) -> int:
        """Exit code 0."""
        from experiments.studies import rebuild_report

        rebuild_report(self.folder).show()
        return 0


@dataclass(frozen=True)
class Merge:
    """Puts shards of a study together: `beltgrasp merge out/loop-shard-* --out out/loop`."""

    folders: Annotated[Positional[tuple[Path, ...]], arg(metavar="DIR")]
    """Results folders that were written with --shard, finished or not."""
    out: Annotated[Path, arg(metavar="DIR")]
    """Folder of the whole study; one that an earlier merge left gets what is new."""

    def run(self) -> int:
        """Exit code 0, also where jobs are missing: they are named, and can be run."""
        from experiments.studies import study_of
        from experiments.study.merge import merge

        if not self.folders:
            raise ValueError("merge needs the folder of one shard at least")
        merged = merge(study_of(self.folders[0]), self.folders, self.out)
        print(f"{merged.job_count} jobs: {merged.rows_path}")
        for line in merged.missing:
            print(f"beltgrasp: warning: {line}", file=sys.stderr)
        if merged.missing:
            print(
                "beltgrasp: warning: merge again when they are there, or run them in the merged "
                f"folder: the command of a shard, without --shard and with --out {self.out}",
                file=sys.stderr,
            )
        else:
            print(f"tables and figures: beltgrasp report {self.out}")
        return 0


@dataclass(frozen=True)
class Compare:
    """Says which of two methods is better: `beltgrasp compare out/filters:igpf out/mine`."""

    first: Annotated[Positional[str], arg(metavar="DIR[:METHOD]")]
    """Results folder of any study, and the tracker, method or controller where it holds several."""
    second: Annotated[Positional[str], arg(metavar="DIR[:METHOD]")]
    """The one to compare with; what both have met is paired."""

    def run(self) -> int:
        """Exit code 0, whoever is better."""
        from experiments.studies import compare

        print("\n".join(compare(self.first, self.second)))
        return 0


@dataclass(frozen=True)
class List:
    """Names everything that the other commands accept, a line each."""

    def run(self) -> int:
        """Exit code 0."""
        from experiments.catalogue import catalogue

        kinds = catalogue()
        width = max(len(name) for names in kinds.values() for name in names)
        for kind, names in kinds.items():
            print(f"{kind}:")
            for name, description in names.items():
                print(f"  {name:<{width}}  {description}")
        return 0


Command: TypeAlias = (
    Annotated[Trial, subcommand("trial")]
    | Annotated[Sweep, subcommand("sweep")]
    | Annotated[Merge, subcommand("merge")]
    | Annotated[Report, subcommand("report")]
    | Annotated[Compare, subcommand("compare")]
    | Annotated[List, subcommand("list")]
    | Annotated[View, subcommand("view")]
    | Annotated[Otb, subcommand("otb")]
    | Annotated[Apple, subcommand("apple")]
    | Annotated[BearingOnly, subcommand("bearing-only")]
)


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point of the console script; ends with SystemExit."""
    sys.exit(run(arguments))


def run(arguments: Sequence[str] | None = None) -> int:
    """Runs a command line and returns its exit code; what the user got wrong becomes one line."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if words == ["--version"]:
        print(f"beltgrasp {package_version('beltgrasp')}, commit {code_version()}")
        return 0
    command = _parse(words)
    if isinstance(command, int):
        return command
    try:
        return command.run()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        return _fail("interrupted", INTERRUPT_EXIT)
    except (ValueError, OSError, RuntimeError) as error:
        if not _is_the_users(error):
            raise
        return _fail(str(error), USAGE_EXIT)


def _is_the_users(error: Exception) -> bool:
    """Whether one line is enough: a RuntimeError is, if it says that rendering is impossible."""
    return not isinstance(error, RuntimeError) or type(error).__name__ == "OffscreenGLError"


def _fail(message: str, exit_code: int) -> int:
    print(f"beltgrasp: error: {' '.join(message.split())}", file=sys.stderr)
    return exit_code


def _parse(arguments: Sequence[str]) -> Command | int:
    """The command, or the exit code of a command line that ends at once."""
    complaint = io.StringIO()
    try:
        with contextlib.redirect_stderr(complaint):
            return tyro.cli(
                Command,
                prog="beltgrasp",
                description="Vision-guided grasping from a moving conveyor, in MuJoCo.",
                args=arguments,
                config=(tyro.conf.OmitSubcommandPrefixes, tyro.conf.FlagCreatePairsOff),
            )
    except ValueError as error:
        return _fail(str(error), USAGE_EXIT)
    except SystemExit as end:
        if not complaint.getvalue():
            return int(end.code or 0)
        return _fail(_in_one_line(complaint.getvalue()), USAGE_EXIT)


def _in_one_line(complaint: str) -> str:
    """The first paragraph of tyro's error box, and what it suggests.

    The box is drawn with lines or, where the encoding has none, with hyphens.
    """
    _, *lines = (line.strip(" │") for line in complaint.splitlines())
    groups = itertools.groupby(lines, lambda line: set(line) <= set("─-╰╯"))
    first, *rest = [list(group) for is_rule, group in groups if not is_rule]
    what = " ".join(first)
    hints = [" ".join(group) for group in rest if group[0].startswith("Available subcommands")]
    if hints:
        known = re.findall(r"[a-z-]+", hints[0].partition(":")[2])
        wrong = re.findall(r"[^\s,]+", what.partition(":")[2])
        near = difflib.get_close_matches(wrong[0], known, n=1) if wrong else []
    else:
        flags = (re.match(r"--[a-z][a-z-]*", line) for group in rest for line in group)
        near = [match[0] for match in flags if match]
    if near and what.startswith("Unrecognized"):
        hints.append("did you mean " + " or ".join(dict.fromkeys(near)) + "?")
    return "; ".join([what, *hints])


if __name__ == "__main__":
    main()
