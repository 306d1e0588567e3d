"""Renders the benchmark's sequences, each with a random stream of its own.

A folder is there when its sequence is complete, and never half, so the same call resumes. No
sequence depends on which others are made, in which order, or by how many processes.
"""

from __future__ import annotations

import hashlib
import shutil
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tqdm import tqdm

from experiments.seeding import Stream, generator
from experiments.study import processes
from experiments.study.manifest import code_version, package_version
from experiments.study.results_folder import exclusive
from experiments.video.clips import RECIPES
from experiments.video.make_files import Source, read_source, write_index, write_sequence
from experiments.video.selection import select
from sim.video.film import shoot


def make_benchmark(
    out: Path, names: Sequence[str] = (), seed: int = 0, workers: int = 1
) -> list[str]:
    """Renders what `out` lacks, and returns the names of the sequences that were asked for.

    Args:
        out: Folder of the benchmark; made where it does not exist.
        names: Names or attributes of sequences, or TB-50; all of them where empty.
        seed: Draws motion, pictures and noise of every sequence.
        workers: Processes; the images and their truth do not depend on it.
    """
    if workers < 1:
        raise ValueError(f"workers must be 1 or greater, got {workers}")
    tags = {name: recipe.attributes for name, recipe in RECIPES.items()}
    chosen, complaints = select(tags, [(name, "--only") for name in names])
    if complaints:
        raise ValueError("; ".join(complaints))
    chosen = chosen if names else list(RECIPES)
    sequence_rng(chosen[0], seed)  # complains of a bad seed before anything is written
    with exclusive(out):
        missing = [name for name in chosen if not _is_made(out / name, seed)]
        lengths = {name: RECIPES[name].clip.frame_count for name in chosen}
        total = sum(lengths.values())
        done = total - sum(lengths[name] for name in missing)
        with tqdm(total=total, initial=done, unit="frame", desc="otb make", disable=None) as bar:
            for name in _make_all([_Job(out, name, seed) for name in missing], workers):
                bar.update(lengths[name])
        made = [name for name in RECIPES if (out / name).is_dir()]
        selection = "" if len(made) == len(RECIPES) else f" --only {','.join(made)}"
        write_index(out, [read_source(out / name) for name in made], selection)
    return chosen


def sequence_rng(name: str, seed: int) -> np.random.Generator:
    """The generator that draws everything random about a sequence."""
    return generator(seed, Stream.FOOTAGE, name)


def source_of(name: str, seed: int) -> Source:
    """The source of a sequence that this code makes."""
    recipe = RECIPES[name]
    return Source(
        name=name,
        attributes=" ".join(recipe.attributes),
        frames=recipe.clip.frame_count,
        seed=seed,
        recipe=hashlib.sha256(repr(recipe).encode()).hexdigest()[:12],
        beltgrasp=package_version("beltgrasp"),
        commit=str(code_version()),
        mujoco=package_version("mujoco"),
        description=recipe.clip.description,
    )


@dataclass(frozen=True)
class _Job:
    out: Path
    name: str
    seed: int


def _make_all(jobs: Sequence[_Job], workers: int) -> Generator[str, None, None]:
    """Makes the sequences and yields their names as they are done."""
    if workers == 1 or len(jobs) < 2:
        yield from map(_make_one, jobs)
        return
    for answer in processes.run_all(_make_one, jobs, workers):
        if isinstance(answer, processes.Lost):
            raise OSError(f"{answer.task.name}: {answer.remark}")
        yield answer


def _make_one(job: _Job) -> str:
    frames = shoot(RECIPES[job.name].clip, sequence_rng(job.name, job.seed))
    with _whole_folder(job.out / job.name) as folder:
        write_sequence(folder, frames, source_of(job.name, job.seed))
    return job.name


@contextmanager
def _whole_folder(path: Path) -> Generator[Path, None, None]:
    """A new folder beside `path`, which takes that name when the block has ended well."""
    partial = path.with_name(f".{path.name}.part")
    shutil.rmtree(partial, ignore_errors=True)
    partial.mkdir(parents=True)
    yield partial
    partial.rename(path)


def _is_made(folder: Path, seed: int) -> bool:
    """Whether the folder holds this sequence; ValueError where it holds another."""
    if not folder.exists():
        return False
    found, wanted = read_source(folder), source_of(folder.name, seed)
    for field in ("seed", "recipe"):
        if getattr(found, field) != getattr(wanted, field):
            raise ValueError(
                f"{folder} was made with {field} {getattr(found, field)}, not "
                f"{getattr(wanted, field)}; choose another folder or remove this one"
            )
    return True
