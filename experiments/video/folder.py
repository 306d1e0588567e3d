"""The manifest of a folder of OTB results: which sequences, which settings of which tracker."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from experiments.study import manifest
from experiments.study.manifest import OTHER_FOLDER
from experiments.video.contestants import get_contestant


def open_manifest(out: Path, root: Path, trackers: Sequence[str], workers: int) -> None:
    """Claims a new results folder, or notes that more is run into it.

    Raises ValueError where it holds results of other sequences or of other settings of a tracker:
    they would stand beside each other in one table.
    """
    content: dict[str, Any] = manifest.read_manifest(out) or _identity(out, root)
    if "root" not in content:
        raise ValueError(f"{out} holds results of another command; {OTHER_FOLDER}")
    earlier = root_of(out, content)
    if earlier.resolve() != root.resolve():
        raise ValueError(f"{out} holds results of the sequences in {earlier}; {OTHER_FOLDER}")
    settings: dict[str, str] = content["settings"]
    for tracker in trackers:
        if settings.setdefault(tracker, _settings_hash(tracker)) != _settings_hash(tracker):
            raise ValueError(
                f"{out} holds results of other settings of {tracker!r}; {OTHER_FOLDER}"
            )
    content["sessions"].append(manifest.session(workers))
    manifest.write_manifest(out, content)
    manifest.warn_of_mixed_code(out)


def root_of(out: Path, content: dict[str, Any]) -> Path:
    """The folder of sequences; the manifest tells it from the results folder."""
    return Path(os.path.abspath(out / content["root"]))


def _identity(out: Path, root: Path) -> dict[str, Any]:
    if (out / "boxes").exists():
        raise ValueError(f"{out} holds boxes without their manifest.json; {OTHER_FOLDER}")
    return {"root": os.path.relpath(root, out), "settings": {}, "sessions": []}


def _settings_hash(tracker: str) -> str:
    return hashlib.sha256(get_contestant(tracker).settings.encode()).hexdigest()[:16]
