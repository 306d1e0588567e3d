"""The commands `beltgrasp sweep` and `beltgrasp merge`: many attempts, on one machine or many."""

from __future__ import annotations

import contextlib
import shlex
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import Positional, arg

from experiments.study.arguments import seed_range, split_names, worker_count
from experiments.study.exits import CRASH_EXIT, INTERRUPT_EXIT

if TYPE_CHECKING:
    from experiments.belt.sweep import SweepSummary
    from experiments.study.processes import Workers

# Everything heavy is imported inside the commands, so that --help answers at once.


@dataclass(frozen=True)
class Sweep:
    """Runs a preset into a folder; the same command again resumes: `beltgrasp sweep demo`."""

    preset: Annotated[Positional[str], arg(metavar="PRESET")]
    """Name of the preset; `beltgrasp list` names them."""
    out: Annotated[Path | None, arg(metavar="DIR")] = None
    """Results folder; out/PRESET if not given, and out/PRESET-shard-I-of-N for a shard."""
    workers: Annotated[int | None, arg(metavar="N")] = None
    """Worker processes; one for each processor if not given. The results do not depend on it."""
    trackers: Annotated[tuple[str, ...], arg(metavar="NAMES")] = ()
    """Only these, with commas or spaces between; one that the preset lacks, also an import path,
    takes the cells of its first tracker."""
    seeds: Annotated[int | None, arg(metavar="N")] = None
    """Only the first N seeds: a quick look."""
    shard: Annotated[str | None, arg(metavar="I/N")] = None
    """Only the I-th of N parts; `beltgrasp merge` puts them together."""
    dask: Annotated[str | None, arg(metavar="ADDRESS")] = None
    """Runs on the workers of this Dask scheduler, as tcp://HOST:8786, and starts none here."""
    video: Literal["none", "failures", "all"] = "none"
    """Of which trials videos are made, when all have their rows; the rows do not depend on it."""

    def run(self) -> int:
        """Exit code 0, or 1 if any trial crashed or a video could not be made."""
        from experiments.belt.presets import PRESETS
        from experiments.belt.sweep import SweepInterrupted, run_sweep
        from experiments.catalogue import check_worlds, require_known
        from experiments.study.shards import Shard

        require_known("preset", self.preset, PRESETS)
        if self.seeds is not None:
            seed_range(self.seeds)
        preset = PRESETS[self.preset].restricted(split_names(self.trackers), self.seeds)
        out = Path("out") / self.preset
        if self.shard is not None:
            shard = Shard.parse(self.shard)
            preset = replace(preset, shard=shard)
            out = out.with_name(f"{self.preset}-shard-{shard.number}-of-{shard.count}")
        out = self.out or out
        with self._workers() as workers:
            check_worlds(preset.cells)
            try:
                done = run_sweep(preset, out, workers, self.video)
            except SweepInterrupted as interrupt:
                print(f"beltgrasp: {interrupt}; the same command resumes:", file=sys.stderr)
                print(f"  {self._command(out)}", file=sys.stderr)
                return INTERRUPT_EXIT
        return _tell(done, out)

    def _workers(self) -> contextlib.AbstractContextManager[Workers]:
        from experiments.study.processes import LocalWorkers

        if self.dask is None:
            return contextlib.nullcontext(LocalWorkers(worker_count(self.workers)))
        if self.workers is not None:
            raise ValueError("workers are those of the Dask scheduler; give --workers or --dask")
        from experiments.study.cluster import DaskWorkers

        return DaskWorkers(self.dask)

    def _command(self, out: Path) -> str:
        words = ["beltgrasp", "sweep", self.preset, "--out", str(out)]
        words += ["--trackers", *self.trackers] if self.trackers else []
        options = {"seeds": self.seeds, "shard": self.shard, "dask": self.dask}
        options |= {"video": None if self.video == "none" else self.video}
        for name, value in options.items():
            words += [] if value is None else [f"--{name}", str(value)]
        return shlex.join(words)


@dataclass(frozen=True)
class Merge:
    """Puts shards of a sweep together: `beltgrasp merge out/loop-shard-* --out out/loop`."""

    folders: Annotated[Positional[tuple[Path, ...]], arg(metavar="DIR")]
    """Results folders of `beltgrasp sweep --shard`, finished or not."""
    out: Annotated[Path, arg(metavar="DIR")]
    """Folder of the whole sweep; one that an earlier merge left gets what is new."""

    def run(self) -> int:
        """Exit code 0, also where trials are missing: they are told, and can be run."""
        from experiments.study.merge import merge

        merged = merge(self.folders, self.out)
        print(f"{merged.trial_count} rows: {merged.trials_path}")
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


def _tell(done: SweepSummary, out: Path) -> int:
    """Prints what a sweep has left, and returns its exit code."""
    print(f"{done.success_count} of {done.trial_count} grasps succeeded: {done.trials_path}")
    if done.video_count:
        print(f"{done.video_count} videos: {out / 'videos'}")
    print(f"tables and figures: beltgrasp report {out}")
    if done.error_count:
        print(
            f"beltgrasp: {done.error_count} trials crashed; tracebacks: {out / 'errors'}",
            file=sys.stderr,
        )
    return CRASH_EXIT if done.error_count or done.lost_video_count else 0
