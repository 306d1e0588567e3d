"""Puts the shards of a study together: rows, timings, curves and files, as of the whole."""

import shutil
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from experiments.study.files import exclusive
from experiments.study.folder import (
    ROWS,
    Entry,
    read_entries,
    write_entries,
)
from experiments.study.manifest import (
    FILE,
    OTHER_FOLDER,
    Manifest,
    jobs_of,
    require_study,
    warn_of_mixed_code,
)
from experiments.study.shard import Shard
from experiments.study.study import Key, Study

_NAMED = 3
"""As many missing jobs of a shard are named."""
_OWN = {"tables", "figures"}
"""What is written anew, not copied."""


@dataclass(frozen=True)
class MergeSummary:
    """What has come together."""

    rows_path: Path
    job_count: int
    """Jobs that have a row now."""
    missing: tuple[str, ...]
    """A line about each shard that is not there, or not whole; or about the whole."""


@dataclass(frozen=True)
class _Part:
    """A folder that holds rows of the study: a shard, or what an earlier merge made of some."""

    path: Path
    study: Study[Any, Any]
    manifest: Manifest

    @cached_property
    def entries(self) -> dict[Key, Entry]:
        """What is kept of each job; ValueError where a row is not of this part of the study."""
        entries = read_entries(self.path, self.study)
        strangers = entries.keys() - {self.study.key_of(j) for j in self.manifest.jobs(self.study)}
        if strangers:
            row = " ".join(min(strangers))
            raise ValueError(f"{self.path} holds a row of another selection: {row}")
        return entries

    @property
    def sessions(self) -> list[dict[str, Any]]:
        """The runs that left its rows, each with its shard."""
        shard, sessions = self.manifest.shard, self.manifest.sessions
        return sessions if shard is None else [{"shard": str(shard)} | s for s in sessions]


def merge(study: Study[Any, Any], folders: Sequence[Path], out: Path) -> MergeSummary:
    """Writes the rows of all `folders` to `out`; what is still missing there can be run there.

    Args:
        study: The study of which the folders are shards.
        folders: Results folders of shards, finished or not.
        out: New folder, or one that an earlier merge of the same study left; its rows stay.

    Raises ValueError where the folders are not of one study, or tell one job differently.
    """
    with exclusive(out):
        paths = [*folders] if Manifest.read(out) is None else [out, *folders]
        if paths[0] != out and any(out.glob("*.csv")):
            raise ValueError(f"{out} holds results without their {FILE}; {OTHER_FOLDER}")
        parts = [_read_part(path, study, out) for path in paths]
        whole = Manifest(study.name)
        for part in parts:
            whole.add_settings(part.manifest.settings, part.path)
            for selection in part.manifest.selections:
                whole.add_selection(study, selection)
            whole.sessions += [s for s in part.sessions if s not in whole.sessions]
        entries = _collect(parts)
        keys = [key for job in whole.jobs(study) if (key := study.key_of(job)) in entries]
        whole.write(out)
        for part in parts:
            _copy_companions(part.path, out)
        write_entries(out, study, [entries[key] for key in keys])
        warn_of_mixed_code(whole, out)
    return MergeSummary(out / ROWS, len(entries), tuple(_missing(parts, whole, entries)))


def _read_part(path: Path, study: Study[Any, Any], out: Path) -> _Part:
    manifest = Manifest.read(path)
    if manifest is None:
        raise ValueError(f"{path} holds no results: it has no {FILE}")
    require_study(manifest, study.name, path)
    if path.resolve() == out.resolve() and manifest.shard is not None:
        raise ValueError(f"{out} holds shard {manifest.shard}; {OTHER_FOLDER}")
    return _Part(path, study, manifest)


def _collect(parts: Iterable[_Part]) -> dict[Key, Entry]:
    """What is kept of each job; one that two parts hold must be the same in both.

    A job that crashed in one part and has a good row in another has the good one.
    """
    entries: dict[Key, Entry] = {}
    origin: dict[Key, Path] = {}
    for part in parts:
        for key, entry in part.entries.items():
            known = entries.get(key)
            if known is not None and not (known.is_error or entry.is_error):
                if known.repeatable != entry.repeatable:
                    raise ValueError(
                        f"{part.study.unit} {' '.join(key)} has one row or curve in {origin[key]} "
                        f"and another in {part.path}"
                    )
            if known is None or (known.is_error and not entry.is_error):
                entries[key], origin[key] = entry, part.path
    return entries


def _copy_companions(source: Path, out: Path) -> None:
    """Copies tracebacks, videos and whatever else stands beside the rows."""
    if source.resolve() == out.resolve():
        return
    for path in sorted(source.iterdir()):
        if path.is_dir() and path.name not in _OWN:
            unfinished = shutil.ignore_patterns(".*")
            shutil.copytree(path, out / path.name, ignore=unfinished, dirs_exist_ok=True)


def _missing(parts: Sequence[_Part], whole: Manifest, entries: dict[Key, Entry]) -> Iterable[str]:
    """A line for each shard of which jobs are missing, or one for folders that are no shards."""
    study = parts[0].study
    counts = {part.manifest.shard.count for part in parts if part.manifest.shard is not None}
    count = counts.pop() if len(counts) == 1 else 1
    for number in range(1, count + 1):
        shard = Shard(number, count)
        jobs = jobs_of(study, whole.selections, shard)
        missing = [study.title(job) for job in jobs if study.key_of(job) not in entries]
        if missing:
            more = f"; and {len(missing) - _NAMED} more" if len(missing) > _NAMED else ""
            part = f"shard {shard} lacks" if count > 1 else "missing:"
            yield (
                f"{part} {len(missing)} of {len(jobs)} {study.unit}s: "
                f"{'; '.join(missing[:_NAMED])}{more}"
            )
