"""The command `beltgrasp otb make`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg


@dataclass(frozen=True)
class Make:
    """Renders video sequences with exact truth: `beltgrasp otb make --out out/otb`."""

    out: Annotated[Path, arg(metavar="DIR")]
    """Folder for the sequences; the same command again resumes."""
    sequences: Annotated[str, arg(metavar="LIST")] = ""
    """Names or attributes, separated by commas, such as `Door,OCC`; all if not given."""
    seed: int = 0
    """Draws motion, pictures and noise; another seed gives another benchmark of the same kind."""
    workers: Annotated[int | None, arg(metavar="N")] = None
    """Worker processes; one for each processor if not given. The files do not depend on it."""

    def run(self) -> int:
        """Exit code 0."""
        from experiments.otb.make import make_benchmark
        from experiments.rendering import gl_renderer
        from experiments.sweep import default_worker_count

        gl_renderer()
        wanted = [word.strip() for word in self.sequences.split(",") if word.strip()]
        workers = default_worker_count() if self.workers is None else self.workers
        names = make_benchmark(self.out, wanted, self.seed, workers)
        count = f"{len(names)} sequence{'s' if len(names) > 1 else ''}"
        print(f"{count}: {self.out}")
        return 0
