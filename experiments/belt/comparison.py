"""Two trackers on the worlds that both have met: better, worse or undecided, and how sure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.belt.config import TrialResult
from experiments.report.grouping import SETTING, World, label, world_of
from experiments.report.statistics import (
    mcnemar_exact,
    newcombe_paired_difference,
    paired_sample_size,
)
from experiments.study import records

SIGNIFICANCE = 0.05


@dataclass(frozen=True)
class Contestant:
    """A tracker in a results folder."""

    folder: Path
    tracker: str
    results: tuple[TrialResult, ...]

    @classmethod
    def parse(cls, text: str) -> Contestant:
        """The contestant of `DIR:TRACKER`, or of `DIR` where that holds one tracker only."""
        folder, colon, tracker = text.rpartition(":")
        if not colon or Path(text).is_dir():
            folder, tracker = text, ""
        results = records.read_rows(Path(folder) / "trials.csv", TrialResult)
        present = list(dict.fromkeys(row.tracker for row in results))
        if not tracker and len(present) == 1:
            tracker = present[0]
        if tracker not in present:
            wanted = f"got {tracker!r}" if tracker else "say which: DIR:TRACKER"
            raise ValueError(f"tracker of {folder} must be one of {', '.join(present)}; {wanted}")
        return cls(Path(folder), tracker, tuple(r for r in results if r.tracker == tracker))

    @property
    def label(self) -> str:
        """Name for people."""
        return f"{self.tracker} ({self.folder})"

    @property
    def particle_counts(self) -> set[int]:
        """Particle counts that it was tried with."""
        return {row.particle_count for row in self.results}

    def success_of_world(self, *, by_particles: bool) -> dict[World, bool]:
        """How each world ended; with `by_particles` each count of particles for itself."""
        return {
            (row.particle_count if by_particles else None, *world_of(row)): row.success
            for row in self.results
        }


@dataclass(frozen=True)
class Comparison:
    """The successes of two contestants on the same n worlds."""

    both: int
    first_only: int
    second_only: int
    neither: int

    @classmethod
    def of(cls, first: Mapping[World, bool], second: Mapping[World, bool]) -> Comparison:
        """Pairs the worlds that both have met."""
        pairs = Counter((first[world], second[world]) for world in first if world in second)
        return cls(pairs[True, True], pairs[True, False], pairs[False, True], pairs[False, False])

    @property
    def n(self) -> int:
        """Worlds that both have met."""
        return self.both + self.first_only + self.second_only + self.neither

    @property
    def difference(self) -> tuple[float, float, float]:
        """Success rate of the first minus the second, and its 95 % interval [Newcombe1998]."""
        return newcombe_paired_difference(
            self.both, self.first_only, self.second_only, self.neither
        )

    @property
    def p(self) -> float:
        """Two-sided, exact [McNemar1947]."""
        return mcnemar_exact(self.first_only, self.second_only)

    @property
    def verdict(self) -> str:
        """`better`, `worse` or `undecided`, of the first."""
        if self.p >= SIGNIFICANCE:
            return "undecided"
        return "better" if self.first_only > self.second_only else "worse"

    @property
    def worlds_to_decide(self) -> int | None:
        """Worlds in all that would decide a difference like the observed one; None for none."""
        return paired_sample_size(self.first_only, self.second_only, self.n)


def compare(first: Contestant, second: Contestant) -> dict[tuple[Any, ...], Comparison]:
    """A comparison for each setting that both have met, in the order of the first.

    A setting is the particle count and the values of `SETTING`. The count is the tracker's own, so
    150 particles of one may meet 300 of the other, and it is None; where one contestant has been
    tried with several, like is compared with like.
    """
    by_particles = any(len(one.particle_counts) > 1 for one in (first, second))
    mine, theirs = (one.success_of_world(by_particles=by_particles) for one in (first, second))
    shared = [world for world in mine if world in theirs]
    if not shared:
        raise ValueError(
            f"{first.label} and {second.label} have no world in common{_apart(first, second)}"
        )
    settings: dict[tuple[Any, ...], list[World]] = {}
    for world in shared:
        settings.setdefault(world[:-1], []).append(world)
    return {
        setting: Comparison.of({w: mine[w] for w in worlds}, theirs)
        for setting, worlds in settings.items()
    }


def pooled(comparisons: Sequence[Comparison]) -> Comparison:
    """All pairs together."""
    names = ("both", "first_only", "second_only", "neither")
    return Comparison(*(sum(getattr(c, name) for c in comparisons) for name in names))


def verdict_lines(first: Contestant, second: Contestant) -> list[str]:
    """What people want to know: each setting in a line, and all together."""
    settings = compare(first, second)
    keys = ("particle_count", *SETTING)
    varying = [k for k in range(len(keys)) if len({setting[k] for setting in settings}) > 1]
    lines = [f"{first.label} against {second.label}, success in the same worlds:"]
    if len(settings) > 1:
        for setting, comparison in settings.items():
            name = ", ".join(label(keys[k], setting[k]) for k in varying)
            lines.append(f"  {name}: {_sentence(comparison)}")
    return [*lines, f"all together: {_sentence(pooled(list(settings.values())))}"]


def _apart(first: Contestant, second: Contestant) -> str:
    """The columns in which no value of one is a value of the other, in words."""
    names = [
        name
        for name in (*SETTING, "seed", "particle_count")
        if {getattr(row, name) for row in first.results}.isdisjoint(
            getattr(row, name) for row in second.results
        )
    ]
    return f"; no value is shared of {', '.join(names)}" if names else ""


def _sentence(c: Comparison) -> str:
    difference, low, high = (f"{100 * value:+.1f}" for value in c.difference)
    text = f"{c.verdict}, {difference} points [{low}, {high}], p {c.p:.2g}, n {c.n}"
    if c.verdict != "undecided":
        return text
    needed = c.worlds_to_decide
    if needed is None:
        return f"{text}; as often better as worse, so no number of worlds is known to decide"
    more = max(needed - c.n, 0)
    return f"{text}; some {more} more worlds would decide, if the difference is like this one"
