"""Two methods on what both have met: one side of a comparison, and the scores of its rows."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic

import numpy as np

from experiments.report.compare import Method, Scale, compare_scores
from experiments.seeding import Stream, generator
from experiments.study.study import Row, Score, Study


@dataclass(frozen=True)
class Side(Generic[Row]):
    """A method in a results folder."""

    folder: Path
    study: Study[Any, Row]
    method: str
    rows: tuple[Any, ...]

    @classmethod
    def of(
        cls, folder: Path, study: Study[Any, Row], rows: Sequence[Row], method: str
    ) -> Side[Row]:
        """The rows of a method; without a name, of the only one.

        Raises ValueError for a method that is not there, with those that are, and for a study
        that compares none.
        """
        if study.score is None:
            raise ValueError(f"{folder}: {study.name} compares no methods")
        present = list(dict.fromkeys(str(getattr(row, study.method)) for row in rows))
        if not method and len(present) == 1:
            method = present[0]
        if method not in present:
            wanted = f"got {method!r}" if method else f"say which: DIR:{study.method.upper()}"
            raise ValueError(
                f"{study.method} of {folder} must be one of {', '.join(present)}; {wanted}"
            )
        own = tuple(row for row in rows if str(getattr(row, study.method)) == method)
        return cls(folder, study, method, own)

    @property
    def score(self) -> Score:
        """By what its study compares methods."""
        assert self.study.score is not None
        return self.study.score

    @property
    def label(self) -> str:
        """Name for people."""
        return f"{self.method} ({self.folder})"

    @property
    def scores(self) -> dict[Hashable, float]:
        """What was met -> the score there, the mean over seeds that meet the same.

        Rows of jobs that crashed have none.
        """
        found: dict[Hashable, list[float]] = {}
        for row in self.rows:
            if row.outcome != "error" and (scored := self.score.of(row)) is not None:
                found.setdefault(scored[0], []).append(scored[1])
        return {met: float(np.mean(values)) for met, values in found.items()}


def verdict_lines(first: Side[Any], second: Side[Any]) -> list[str]:
    """The scores of both sides in pairs, and which side is better."""
    score = first.score
    return compare_scores(
        Method(first.label, first.scores),
        Method(second.label, second.scores),
        Scale(score.name, higher_is_better=score.higher_is_better, digits=3),
        generator(0, Stream.BOOTSTRAP),
    )
