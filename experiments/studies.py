"""Every study by its name: the subject's part of it says where the study is described."""

import importlib
from pathlib import Path
from typing import Any

from experiments.report.report import Report
from experiments.study.compare import Side
from experiments.study.folder import read_results
from experiments.study.manifest import FILE, Manifest
from experiments.study.study import Study, load
from tracker.checks import require_known

SUBJECTS = {
    "belt": "experiments.belt.study",
    "video": "experiments.video.study",
    "apple": "experiments.apple.study",
    "bearing-only": "experiments.bearing_only.study",
}
"""Subject -> module whose `get_study` knows its studies; imported when one is asked for."""


def get_study(name: str) -> Study[Any, Any]:
    """The study `subject/study`; ValueError lists the known ones for another name."""
    subject = name.partition("/")[0]
    require_known("subject of the study", subject, SUBJECTS)
    return importlib.import_module(SUBJECTS[subject]).get_study(name)


def study_of(folder: Path) -> Study[Any, Any]:
    """The study that a results folder holds; ValueError where it holds none."""
    manifest = Manifest.read(folder)
    if manifest is None:
        raise ValueError(f"{folder} holds no results: it has no {FILE}")
    return get_study(manifest.study)


def compare(first: str, second: str) -> list[str]:
    """Compares `DIR:METHOD`, or `DIR` where that holds one method only, with another."""
    sides = [_side_of(text) for text in (first, second)]
    one, other = (side.study for side in sides)
    if one.row is not other.row:
        raise ValueError(f"{first} holds results of {one.name}, {second} of {other.name}")
    return load(sides[0].study.compare)(*sides)


def _side_of(text: str) -> Side[Any]:
    folder, colon, method = text.rpartition(":")
    if not colon or Path(text).is_dir():
        folder, method = text, ""
    path = Path(folder)
    if not path.is_dir() and ":" in folder:  # the method is an import path
        folder, _, module = folder.rpartition(":")
        path, method = Path(folder), f"{module}:{method}"
    study = study_of(path)
    return Side[Any].of(path, study, read_results(path, study).rows, method)


def rebuild_report(folder: Path) -> Report:
    """Writes the tables and figures of a results folder of any study anew."""
    study = study_of(folder)
    return load(study.report)(read_results(folder, study))
