"""The command `beltgrasp`: one attempt, a sweep of many, tables and figures, OTB, apples."""

from __future__ import annotations

import contextlib
import io
import json
import os
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, TypeAlias

import tyro
from tyro.conf import Positional, arg, subcommand

from experiments.apple.cli import Apple
from experiments.bearing_only.commands import BearingOnly
from experiments.belt.commands import Merge, Sweep
from experiments.belt.config import TrialConfig
from experiments.study.exits import CRASH_EXIT, INTERRUPT_EXIT, USAGE_EXIT
from experiments.video.commands import Otb

# Everything heavy is imported inside the commands, so that --help answers at once.


@dataclass(frozen=True)
class Trial:
    """Runs one attempt and prints its row: `beltgrasp trial --tracker igpf --speed-mps 0.25`."""

    config: Annotated[TrialConfig, arg(name="")]
    video: Annotated[Path | None, arg(metavar="FILE")] = None
    """Writes an MP4: the camera's view with warp, particles and phase, beside the cell."""
    json: bool = False
    """Prints the row as one JSON object instead of a summary."""

    def run(self) -> int:
        """Exit code 0, or 1 for an attempt that crashed; a failed grasp is no crash."""
        from experiments.belt.summary import summary_lines
        from experiments.catalogue import check_worlds
        from experiments.study import manifest, processes, workers

        processes.limit_threads()
        check_worlds([self.config])
        if self.video is not None:
            self.video.parent.mkdir(parents=True, exist_ok=True)
        job = workers.TrialJob("trial", manifest.provenance())
        attempt = workers.attempt(job, 0, self.config, self.video)
        if attempt.crash is not None:
            print(attempt.crash.rstrip(), file=sys.stderr)
        if self.json:
            from experiments.study.records import to_json

            print(json.dumps(to_json(attempt.result)))
        else:
            print("\n".join(summary_lines(self.config, attempt.result, attempt.timings)))
            if self.video is not None and attempt.crash is None:
                print(f"video: {self.video}")
        return 0 if attempt.crash is None else CRASH_EXIT


@dataclass(frozen=True)
class Report:
    """Rebuilds tables and figures from a folder's trials.csv: `beltgrasp report out/demo`."""

    folder: Annotated[Positional[Path], arg(metavar="DIR")]
    """Results folder of a sweep, finished or not."""

    def run(self) -> int:
        """Exit code 0."""
        from experiments.belt.report import write_report

        write_report(self.folder).show()
        return 0


@dataclass(frozen=True)
class Compare:
    """Says which of two trackers is better: `beltgrasp compare out/filters:igpf out/mine`."""

    first: Annotated[Positional[str], arg(metavar="DIR[:TRACKER]")]
    """Results folder of a sweep, and the tracker where it holds several."""
    second: Annotated[Positional[str], arg(metavar="DIR[:TRACKER]")]
    """The one to compare with; worlds are paired by setting and seed."""

    def run(self) -> int:
        """Exit code 0, whoever is better."""
        from experiments.belt.comparison import Contestant, verdict_lines

        lines = verdict_lines(Contestant.parse(self.first), Contestant.parse(self.second))
        print("\n".join(lines))
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


@dataclass(frozen=True)
class View:
    """Opens MuJoCo's interactive viewer on the scene of a trial; needs a display."""

    config: Annotated[TrialConfig, arg(name="")]

    def run(self) -> int:
        """Exit code 0 when the window is closed."""
        if sys.platform.startswith("linux") and not (
            os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
        ):
            raise OSError("view needs a display, and neither DISPLAY nor WAYLAND_DISPLAY is set")
        from experiments.belt.viewer import show
        from experiments.catalogue import check_worlds

        check_worlds([self.config])
        show(self.config)
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
    command = _parse(sys.argv[1:] if arguments is None else arguments)
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
    is_rule = [set(line) <= set("─-╰╯") for line in lines]
    start = is_rule.index(False)
    end = is_rule.index(True, start)
    first, rest = lines[start:end], lines[end:]
    hints = [line for line in rest if line.startswith("Available subcommands")]
    flags = [match[0] for line in rest if (match := re.match(r"--[a-z][a-z-]*", line))]
    if flags and first[0].startswith("Unrecognized"):
        hints.append("did you mean " + " or ".join(dict.fromkeys(flags)) + "?")
    return "; ".join([" ".join(first), *hints])


if __name__ == "__main__":
    main()
