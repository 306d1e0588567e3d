"""Which study a results folder holds, for the experiments beside the sweeps."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from experiments.study import manifest
from experiments.study.manifest import OTHER_FOLDER


def claim(
    folder: Path,
    kind: str,
    study: str,
    worker_count: int,
    settings: Mapping[str, Any] | None = None,
) -> None:
    """Claims a new results folder for a study, or notes that it goes on there.

    Args:
        folder: Made where it does not exist.
        kind: Entry of the manifest that names the study, such as `apple`.
        study: Name of the study.
        worker_count: Processes.
        settings: What determines its rows, as JSON holds it.

    Raises ValueError where the folder holds results of another study or of other settings.
    """
    wanted = dict(settings or {})
    content: dict[str, Any] | None = manifest.read_manifest(folder)
    if content is None:
        if folder.exists() and any(folder.glob("*.csv")):
            raise ValueError(f"{folder} holds results without their manifest.json; {OTHER_FOLDER}")
        content = {kind: study} | ({"settings": wanted} if wanted else {}) | {"sessions": []}
    if content.get(kind) != study:
        found = content.get(kind, "another command")
        raise ValueError(f"{folder} holds results of {found}, not of {study}; {OTHER_FOLDER}")
    held = content.get("settings", {})
    differing = [name for name, value in wanted.items() if held.get(name) != value]
    if differing:
        told = ", ".join(f"{name} {held.get(name)}, not {wanted[name]}" for name in differing)
        raise ValueError(f"{folder} holds results with {told}; {OTHER_FOLDER}")
    folder.mkdir(parents=True, exist_ok=True)
    content["sessions"].append(manifest.session(worker_count))
    manifest.write_manifest(folder, content)
    manifest.warn_of_mixed_code(folder)


def study_of(folder: Path, kind: str, command: str) -> str:
    """The study that a folder holds; ValueError where it holds none of the command's."""
    content = manifest.read_manifest(folder)
    if content is None or kind not in content:
        raise ValueError(f"{folder} holds no results of `beltgrasp {command}`")
    return content[kind]
