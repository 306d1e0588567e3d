"""The manifest of a folder of apple results: which command, which settings."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from experiments import manifest
from experiments.manifest import OTHER_FOLDER


def open_manifest(out: Path, study: str, settings: dict[str, Any], workers: int) -> None:
    """Claims a new results folder, or notes that the same command runs into it again.

    Args:
        out: Results folder; made where it does not exist.
        study: Name of the command, such as `tables`.
        settings: What determines the rows, as JSON holds it.
        workers: Processes.

    Raises ValueError where it holds results of another command or of other settings.
    """
    content: dict[str, Any] | None = manifest.read_manifest(out)
    if content is None:
        if out.exists() and any(out.glob("*.csv")):
            raise ValueError(f"{out} holds results without their manifest.json; {OTHER_FOLDER}")
        content = {"apple": study, "settings": settings, "sessions": []}
    if content.get("apple") != study:
        raise ValueError(f"{out} holds results of another command; {OTHER_FOLDER}")
    differing = [k for k, v in settings.items() if content["settings"].get(k) != v]
    if differing:
        told = ", ".join(f"{k} {content['settings'].get(k)}, not {settings[k]}" for k in differing)
        raise ValueError(f"{out} holds results with {told}; {OTHER_FOLDER}")
    out.mkdir(parents=True, exist_ok=True)
    content["sessions"].append(manifest.session(workers))
    manifest.write_manifest(out, content)
    manifest.warn_of_mixed_code(out)


def study_of(folder: Path) -> str:
    """Which command of `beltgrasp apple` a folder holds results of; ValueError for none."""
    content = manifest.read_manifest(folder)
    if content is None or "apple" not in content:
        raise ValueError(f"{folder} holds no results of `beltgrasp apple`")
    return content["apple"]
