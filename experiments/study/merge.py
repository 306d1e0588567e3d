"""Puts the shards of a sweep together: rows and curves, with the bytes of the whole."""

from __future__ import annotations

import dataclasses
import shutil
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from experiments.belt.config import TrialConfig, TrialResult
from experiments.belt.presets import Preset
from experiments.study import manifest, records
from experiments.study.results_folder import (
    ERRORS,
    VIDEOS,
    Lines,
    ResultsFolder,
    exclusive,
    read_lines,
    write_lines,
)
from experiments.study.shards import Shard

_NAMED = 3
"""As many missing trials of a shard are told by name."""


@dataclass(frozen=True)
class MergeSummary:
    """What has come together."""

    trials_path: Path
    trial_count: int
    """Trials that have a row now."""
    missing: tuple[str, ...]
    """A line about each shard that is not there, or not whole."""


@dataclass(frozen=True)
class _Part:
    """A folder that holds rows of the sweep: a shard, or what an earlier merge made of some."""

    path: Path
    preset: Preset
    manifest: dict[str, Any]

    @classmethod
    def read(cls, path: Path) -> _Part:
        return cls(path, manifest.read_preset(path), manifest.read_manifest(path) or {})

    @cached_property
    def lines(self) -> dict[str, Lines]:
        """Trial id -> its lines; ValueError where a row is not of this part of the sweep."""
        lines = read_lines(self.path)
        strangers = lines.keys() - {trial.trial_id for trial in self.preset.trials}
        if strangers:
            raise ValueError(f"{self.path} holds a row of another sweep: trial {min(strangers)}")
        return lines

    @property
    def sessions(self) -> list[dict[str, Any]]:
        """The runs that left its rows, each with its shard."""
        sessions: list[dict[str, Any]] = self.manifest.get("sessions", [])
        shard = self.preset.shard
        return sessions if shard is None else [{"shard": str(shard)} | s for s in sessions]


def merge(folders: Sequence[Path], out: Path) -> MergeSummary:
    """Writes the rows of all `folders` to `out`; what is still missing there can be run there.

    Args:
        folders: Results folders of shards of one sweep, finished or not.
        out: New folder, or one that an earlier merge of the same sweep left; its rows stay.

    Raises ValueError where the folders are not of one sweep, or tell one trial differently.
    """
    parts = [_Part.read(folder) for folder in folders]
    if not parts:
        raise ValueError("merge needs the folders of one shard at least")
    with exclusive(out):
        if manifest.read_manifest(out) is not None:
            parts.insert(0, _Part.read(out))
        elif any(out.glob("*.csv")):
            raise ValueError(f"{out} holds results without manifest; {manifest.OTHER_FOLDER}")
        _require_one_sweep(parts, out)
        whole = dataclasses.replace(parts[0].preset, shard=None)
        lines = _collect(parts)
        manifest.write_manifest(out, _manifest(whole, parts))
        places = {trial.trial_id: place for place, trial in enumerate(whole.trials)}
        write_lines(out, {places[trial_id]: line for trial_id, line in lines.items()})
        for part in parts:
            _copy_companions(part.path, out)
        folder = ResultsFolder(out, list(places))
        if not folder.missing:
            rows = records.read_rows(folder.trials_path, TrialResult)
            manifest.close_manifest(out, [row.gl_renderer for row in rows if row.gl_renderer])
        manifest.warn_of_mixed_code(out)
    return MergeSummary(folder.trials_path, len(lines), tuple(_tell_missing(parts, whole, lines)))


def _require_one_sweep(parts: Sequence[_Part], out: Path) -> None:
    first = parts[0]
    for part in parts:
        if part.preset.name != first.preset.name:
            raise ValueError(
                f"{part.path} holds results of preset {part.preset.name!r}, "
                f"{first.path} of {first.preset.name!r}"
            )
        if part.manifest["config_hash"] != first.manifest["config_hash"]:
            raise ValueError(
                f"{part.path} and {first.path} hold preset {first.preset.name!r} "
                "with other cells or seeds"
            )
        if part.path.resolve() == out.resolve() and part.preset.shard is not None:
            raise ValueError(f"{out} holds shard {part.preset.shard}; {manifest.OTHER_FOLDER}")


def _collect(parts: Iterable[_Part]) -> dict[str, Lines]:
    """Trial id -> its lines; a trial that two parts hold must be the same in both."""
    lines: dict[str, Lines] = {}
    origin: dict[str, Path] = {}
    for part in parts:
        for trial_id, line in part.lines.items():
            if lines.get(trial_id, line).repeatable != line.repeatable:
                trial = next(t for t in part.preset.trials if t.trial_id == trial_id)
                raise ValueError(
                    f"trial {trial_id} ({_name(trial)}) has one row or curve in {origin[trial_id]} "
                    f"and another in {part.path}"
                )
            lines.setdefault(trial_id, line)
            origin.setdefault(trial_id, part.path)
    return lines


def _copy_companions(source: Path, out: Path) -> None:
    for name in (ERRORS, VIDEOS):
        if source.resolve() != out.resolve() and (source / name).is_dir():
            unfinished = shutil.ignore_patterns(".*")
            shutil.copytree(source / name, out / name, ignore=unfinished, dirs_exist_ok=True)


def _manifest(whole: Preset, parts: Iterable[_Part]) -> dict[str, Any]:
    """That of the whole sweep: whose shards are in it, and the sessions of all of them."""
    shards: dict[str, int] = {}
    sessions: list[Any] = []
    for part in parts:
        shards |= part.manifest.get("shards", {})
        if part.preset.shard is not None:
            shards[str(part.preset.shard)] = len(part.lines)
        sessions += [session for session in part.sessions if session not in sessions]
    return manifest.identity(whole) | {"shards": shards, "sessions": sessions}


def _tell_missing(
    parts: Sequence[_Part], whole: Preset, lines: Mapping[str, Lines]
) -> Iterable[str]:
    """A line for each shard of which trials are missing."""
    counts = {part.preset.shard.count for part in parts if part.preset.shard is not None}
    count = counts.pop() if len(counts) == 1 else 1
    for number in range(1, count + 1):
        shard = dataclasses.replace(whole, shard=Shard(number, count))
        missing = [_name(trial) for trial in shard.trials if trial.trial_id not in lines]
        if missing:
            more = f"; and {len(missing) - _NAMED} more" if len(missing) > _NAMED else ""
            yield (
                f"shard {shard.shard} lacks {len(missing)} of {len(shard.trials)} trials: "
                f"{'; '.join(missing[:_NAMED])}{more}"
            )


def _name(trial: TrialConfig) -> str:
    return f"{trial.tracker} at {trial.speed_mps:g} m/s, {trial.condition}, seed {trial.seed}"
