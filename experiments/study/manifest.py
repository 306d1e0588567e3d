"""`manifest.json`: which study a results folder holds, with which settings, and what ran where."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, cast

from experiments.study import settings as setting
from experiments.study.files import write_whole
from experiments.study.provenance import code_version, session, utc_now
from experiments.study.settings import Settings
from experiments.study.shard import Shard
from experiments.study.study import Job, Key, Row, Selection, Study

FILE = "manifest.json"
FORMAT = 1
"""Raised when folders that were written before can no longer be read."""
OTHER_FOLDER = "choose another folder"


@dataclass
class Manifest:
    """What a results folder says of itself."""

    study: str
    selections: list[Selection] = field(default_factory=list[Selection])
    """What was asked for, whichever came first; together these are all jobs of the folder."""
    settings: Settings = field(default_factory=dict[str, Any])
    sessions: list[dict[str, Any]] = field(default_factory=list[dict[str, Any]])
    shard: Shard | None = None
    """The part of the study that the folder holds, if not the whole."""

    @classmethod
    def read(cls, folder: Path) -> Manifest | None:
        """The manifest of a folder, None where there is none; ValueError for another format."""
        path = folder / FILE
        if not path.exists():
            return None
        try:
            content: Any = json.loads(path.read_text(encoding="utf-8"))
        except ValueError as error:
            raise ValueError(f"{path} is not valid JSON: {error}") from error
        if not isinstance(content, dict) or "study" not in content or "format" not in content:
            raise ValueError(
                f"{folder} holds results of an earlier version of beltgrasp, whose format this one "
                f"does not read; {OTHER_FOLDER}"
            )
        known = cast(dict[str, Any], content)
        if known.pop("format") != FORMAT:
            raise ValueError(
                f"{folder} holds results of a later version of beltgrasp; {OTHER_FOLDER}"
            )
        shard = known.pop("shard", None)
        try:
            return cls(**known, shard=None if shard is None else Shard.parse(shard))
        except (TypeError, ValueError) as error:
            raise ValueError(f"{path} is not the manifest of a study: {error}") from error

    def write(self, folder: Path) -> None:
        """Replaces the manifest of a folder in one step."""
        content: dict[str, Any] = {"study": self.study, "format": FORMAT}
        if self.shard is not None:
            content["shard"] = str(self.shard)
        content |= {"selections": self.selections, "settings": self.settings}
        content |= {"sessions": self.sessions}
        write_whole(folder / FILE, _compact_json(content))

    def end_session(self, folder: Path) -> None:
        """Notes when the present run ended."""
        self.sessions[-1]["ended_utc"] = utc_now()
        self.write(folder)

    def jobs(self, study: Study[Job, Row]) -> list[Job]:
        """All jobs of the folder in the order of their rows."""
        return jobs_of(study, self.selections, self.shard)

    def add_selection(self, study: Study[Job, Row], selection: Selection) -> None:
        """Adds what a command asks for, in place of selections that it holds.

        One that another holds changes nothing: what is kept does not depend on which came first.
        """
        wanted = _keys(study, selection, self.shard)
        kept = [(_keys(study, s, self.shard), s) for s in self.selections]
        if not any(wanted <= keys for keys, _ in kept):
            others = [s for keys, s in kept if not keys <= wanted]
            self.selections = sorted([selection, *others], key=json.dumps)

    def add_settings(self, wanted: Mapping[str, object], folder: Path) -> None:
        """Adds settings by name; ValueError where the folder holds rows of other ones."""
        try:
            self.settings = setting.merge(self.settings, wanted)
        except ValueError as error:
            raise ValueError(f"{folder} holds results with {error}; {OTHER_FOLDER}") from None


@dataclass(frozen=True)
class Request(Generic[Job]):
    """The jobs that are asked for, and all that determines their rows."""

    selection: Selection
    shard: Shard | None
    jobs: list[Job]
    settings: Mapping[str, object]

    @classmethod
    def of(cls, study: Study[Job, Any], selection: Selection, shard: Shard | None) -> Request[Job]:
        """The request for a selection; ValueError for what there is not, and for no job at all."""
        jobs = jobs_of(study, [selection], shard)
        if not jobs:
            part = "the selection" if shard is None else f"shard {shard}"
            raise ValueError(f"{study.name}: {part} has no {study.unit}")
        settings: dict[str, object] = {}
        for job in jobs:
            settings |= study.settings(job)
        return cls(selection, shard, jobs, settings)


def jobs_of(
    study: Study[Job, Row], selections: Sequence[Selection], shard: Shard | None
) -> list[Job]:
    """The jobs of all selections, or the shard's part of each, in the order of their rows."""
    jobs: dict[Any, Job] = {}
    for selection in selections:
        all_jobs = list(study.jobs(selection))
        for job in all_jobs if shard is None else shard.of(all_jobs):
            jobs.setdefault(study.key_of(job), job)
    return sorted(jobs.values(), key=study.order)


def claim(
    folder: Path, study: Study[Job, Row], request: Request[Job], worker_count: int
) -> Manifest:
    """Claims a new results folder for a study, or notes that the study goes on there.

    Raises ValueError, and changes nothing, where the folder holds results of another study, of
    another part of it, or of other settings.
    """
    manifest = Manifest.read(folder)
    if manifest is None:
        if any(folder.glob("*.csv")):
            raise ValueError(f"{folder} holds results without their {FILE}; {OTHER_FOLDER}")
        manifest = Manifest(study.name, shard=request.shard)
    require_study(manifest, study.name, folder)
    if manifest.shard != request.shard:
        raise ValueError(
            f"{folder} holds {_part(manifest.shard)} of {study.name}, not {_part(request.shard)}; "
            f"{OTHER_FOLDER}"
        )
    manifest.add_settings(request.settings, folder)
    manifest.add_selection(study, request.selection)
    manifest.sessions = [*manifest.sessions, session(worker_count)]
    manifest.write(folder)
    warn_of_mixed_code(manifest, folder)
    return manifest


def require_study(manifest: Manifest, name: str, folder: Path) -> None:
    """Raises ValueError where a folder holds results of another study."""
    if manifest.study != name:
        raise ValueError(
            f"{folder} holds results of {manifest.study}, not of {name}; {OTHER_FOLDER}"
        )


def warn_of_mixed_code(manifest: Manifest, folder: Path) -> None:
    """Says so where rows of a folder come from other code than this."""
    now = str(code_version())
    commits = {f"{s['commit']}{'-dirty' if s['is_dirty'] else ''}" for s in manifest.sessions}
    if others := commits - {now}:
        found = ", ".join(sorted(others))
        print(f"note: earlier rows in {folder} are of code {found}, not {now}", file=sys.stderr)


def _keys(study: Study[Job, Row], selection: Selection, shard: Shard | None) -> set[Key]:
    """Those of all jobs of a selection."""
    return {study.key_of(job) for job in jobs_of(study, [selection], shard)}


def _part(shard: Shard | None) -> str:
    return "the whole" if shard is None else f"shard {shard}"


def _compact_json(content: dict[str, Any]) -> str:
    """JSON with a line for each entry of the two upper levels."""
    lines: list[str] = []
    for name, value in content.items():
        if isinstance(value, dict) and value:
            inner = [
                f"    {json.dumps(k)}: {json.dumps(v)}" for k, v in cast(Settings, value).items()
            ]
            text = "{\n" + ",\n".join(inner) + "\n  }"
        elif isinstance(value, list) and value:
            text = (
                "[\n" + ",\n".join(f"    {json.dumps(v)}" for v in cast(list[Any], value)) + "\n  ]"
            )
        else:
            text = json.dumps(value)
        lines.append(f"  {json.dumps(name)}: {text}")
    return "{\n" + ",\n".join(lines) + "\n}\n"
