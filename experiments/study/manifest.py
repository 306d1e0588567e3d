"""Where results come from: commit, versions, machine and command; `manifest.json` beside them."""

from __future__ import annotations

import dataclasses
import hashlib
import importlib.metadata
import json
import os
import platform
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, cast

from experiments.belt.config import TrialConfig
from experiments.belt.presets import Preset
from experiments.study import records
from experiments.study.shards import Shard

ROOT = Path(__file__).resolve().parents[2]
_CODE = ("sim", "tracker", "experiments", "assets", "pyproject.toml", "uv.lock")
_PACKAGES = ("mujoco", "dm-control", "mink", "numpy", "opencv-python-headless")


@dataclass(frozen=True)
class CodeVersion:
    """The code that ran."""

    commit: str
    """Abbreviated git commit, or the package version where there is no repository."""
    is_dirty: bool
    """Whether code or assets differ from that commit."""

    def __str__(self) -> str:
        return self.commit + ("-dirty" if self.is_dirty else "")


@cache
def code_version() -> CodeVersion:
    """Commit and dirty flag of this checkout, read once per process."""
    if _git("rev-parse", "--show-toplevel") != str(ROOT):
        return CodeVersion(f"v{package_version('beltgrasp')}", is_dirty=False)
    commit = _git("rev-parse", "--short=12", "HEAD") or "uncommitted"
    return CodeVersion(commit, is_dirty=bool(_git("status", "--porcelain", "--", *_CODE)))


def provenance() -> dict[str, str]:
    """The columns of a row that name the code: `commit` and `mujoco_version`."""
    return {"commit": str(code_version()), "mujoco_version": package_version("mujoco")}


def _git(*arguments: str) -> str:
    """Output of a git command in the project's root; empty where git or a repository is missing."""
    command = ["git", "--no-optional-locks", "-C", str(ROOT), *arguments]
    try:
        run = subprocess.run(command, capture_output=True, text=True, timeout=20.0, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return run.stdout.strip() if run.returncode == 0 else ""


def package_version(name: str) -> str:
    """Installed version of a distribution, or `none`."""
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return "none"


def _from_here(word: str) -> str:
    """A path below the working folder, told from there: no home folder goes into the results."""
    here = f"{Path.cwd()}{os.sep}"
    return word.removeprefix(here)


def config_hash(preset: Preset) -> str:
    """Hash of the preset's name and of every field of every trial, in order, of all shards."""
    ids = [trial.trial_id for trial in preset.all_trials]
    return hashlib.sha256(json.dumps([preset.name, ids]).encode()).hexdigest()[:16]


def open_manifest(folder: Path, preset: Preset, worker_count: int) -> None:
    """Claims a new results folder for the preset, or notes that its sweep goes on.

    Raises ValueError where the folder belongs to another preset or holds foreign results.
    """
    manifest, own = read_manifest(folder), identity(preset)
    sessions: list[Any] = [] if manifest is None else manifest.get("sessions", [])
    if manifest is None:
        if (folder / "trials.csv").exists():
            raise ValueError(
                f"{folder} holds a trials.csv without its manifest.json; {OTHER_FOLDER}"
            )
        manifest = own
    elif manifest.get("preset") != preset.name:
        raise ValueError(
            f"{folder} holds results of preset {manifest.get('preset')!r}, "
            f"not of {preset.name!r}; {OTHER_FOLDER}"
        )
    elif manifest.get("config_hash") != own["config_hash"]:
        raise ValueError(
            f"{folder} holds results of another version of preset {preset.name!r}: "
            f"its cells or seeds have changed; {OTHER_FOLDER}"
        )
    elif manifest.get("shard") != own.get("shard"):
        raise ValueError(
            f"{folder} holds {_part(manifest.get('shard'))} of preset {preset.name!r}, "
            f"not {_part(own.get('shard'))}; {OTHER_FOLDER}"
        )
    write_manifest(folder, manifest | {"sessions": [*sessions, session(worker_count)]})


OTHER_FOLDER = "choose another folder or remove this one"


def close_manifest(folder: Path, gl_renderers: Sequence[str]) -> None:
    """Notes that the sweep is complete, and what rendered its images."""
    manifest = read_manifest(folder) or {}
    manifest |= {"gl_renderers": sorted(set(gl_renderers)), "finished_utc": _utc_now()}
    write_manifest(folder, manifest)


def read_manifest(folder: Path) -> dict[str, Any] | None:
    """The manifest of a results folder; None where there is none."""
    path = folder / "manifest.json"
    if not path.exists():
        return None
    try:
        manifest: Any = json.loads(path.read_text())
    except ValueError as error:
        raise ValueError(f"{path} is not valid JSON: {error}") from error
    if not isinstance(manifest, dict):
        raise ValueError(f"{path} must hold a JSON object")
    return cast(dict[str, Any], manifest)


def warn_of_mixed_code(folder: Path) -> None:
    """Says so where rows of a resumed folder come from other code than this."""
    sessions = (read_manifest(folder) or {}).get("sessions", [])
    now = str(code_version())
    others = {f"{s['commit']}{'-dirty' if s['is_dirty'] else ''}" for s in sessions} - {now}
    if others:
        found = ", ".join(sorted(others))
        print(f"note: earlier rows in {folder} are of code {found}, not {now}", file=sys.stderr)


def write_manifest(folder: Path, manifest: dict[str, Any]) -> None:
    """Replaces the manifest of a results folder in one step."""
    records.write_whole(folder / "manifest.json", json.dumps(manifest, indent=2) + "\n")


def identity(preset: Preset) -> dict[str, Any]:
    """What says to which sweep a folder belongs; `read_preset` makes the preset of it again."""
    content: dict[str, Any] = {
        "preset": preset.name,
        "config_hash": config_hash(preset),
        "cell_count": len(preset.cells),
        "trial_count": len(preset.trials),
        "seeds": list(preset.seeds),
        "cells": [_settings(cell) for cell in preset.cells],
    }
    return content if preset.shard is None else content | {"shard": str(preset.shard)}


def read_preset(folder: Path) -> Preset:
    """The sweep, or the shard of one, that a folder holds; ValueError where it tells none."""
    manifest = read_manifest(folder) or {}
    if "cells" not in manifest:
        raise ValueError(f"{folder} has no manifest.json of a sweep that tells its cells")
    try:
        shard = manifest.get("shard")
        preset = Preset(
            name=manifest["preset"],
            description="",
            cells=tuple(TrialConfig(**cell) for cell in manifest["cells"]),
            seeds=tuple(manifest["seeds"]),
            shard=None if shard is None else Shard.parse(shard),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{folder / 'manifest.json'} tells no sweep: {error}") from error
    if manifest["config_hash"] != config_hash(preset):
        raise ValueError(f"{folder} holds results of another version of beltgrasp")
    return preset


def _settings(cell: TrialConfig) -> dict[str, Any]:
    """Where the cell differs from a trial's defaults; the seeds stand apart."""
    standard = dataclasses.asdict(TrialConfig(seed=cell.seed))
    return {k: v for k, v in dataclasses.asdict(cell).items() if v != standard[k]}


def _part(shard: str | None) -> str:
    return "the whole" if shard is None else f"shard {shard}"


def session(worker_count: int) -> dict[str, Any]:
    """One run of the command: a resumed sweep has several."""
    version = code_version()
    return {
        "started_utc": _utc_now(),
        "command": ["beltgrasp", *(_from_here(word) for word in sys.argv[1:])],
        "workers": worker_count,
        "commit": version.commit,
        "is_dirty": version.is_dirty,
        "beltgrasp": package_version("beltgrasp"),
        "python": platform.python_version(),
        "packages": {name: package_version(name) for name in _PACKAGES},
        "platform": platform.platform(),
        "cpu": _cpu_model(),
        "cpu_count": os.cpu_count(),
    }


def _cpu_model() -> str:
    """Name, family and model: libraries choose their kernels by them, and last digits follow."""
    try:
        lines = Path("/proc/cpuinfo").read_text().split("\n\n")[0].splitlines()
    except OSError:
        return platform.processor()
    told = {key.strip(): value.strip() for key, _, value in (line.partition(":") for line in lines)}
    if "model name" not in told:
        return platform.machine()
    kind = [f"{key} {told[key]}" for key in ("cpu family", "model") if key in told]
    return ", ".join([told["model name"], *kind])


def _utc_now() -> str:
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
