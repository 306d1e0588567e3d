"""Two trackers on the worlds that both have met: better, worse or undecided, and how sure."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

from experiments.belt.analysis.cells import SETTING, World, title_of, world_of
from experiments.belt.config import TrialResult
from experiments.report.statistics import (
    SIGNIFICANCE,
    mcnemar_exact,
    newcombe_paired_difference,
    paired_sample_size,
)
from experiments.study.compare import Side


def particle_counts(side: Side[TrialResult]) -> set[int]:
    """Particle counts that a tracker was tried with."""
    return {row.particle_count for row in side.rows}


def success_of_world(side: Side[TrialResult], *, by_particles: bool) -> dict[World, bool]:
    """How each world ended; with `by_particles` each count of particles for itself."""
    return {
        (row.particle_count if by_particles else None, *world_of(row)): row.success
        for row in side.rows
    }


@dataclass(frozen=True)
class Comparison:
    """The successes of two trackers on the same n worlds."""

    both: int
    first_only: int
    second_only: int
    neither: int

    @classmethod
    def of(cls, first: Mapping[World, bool], second: Mapping[World, bool]) -> Self:
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


def compare(
    first: Side[TrialResult], second: Side[TrialResult]
) -> dict[tuple[Any, ...], Comparison]:
    """A comparison for each setting that both have met, in the order of the first.

    A setting is the particle count and the values of `SETTING`. The count is the tracker's own, so
    150 particles of one may meet 300 of the other, and it is None; where one tracker has been
    tried with several, like is compared with like.
    """
    by_particles = any(len(particle_counts(one)) > 1 for one in (first, second))
    mine, theirs = (success_of_world(one, by_particles=by_particles) for one in (first, second))
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
    """Adds up the pairs of several comparisons."""
    names = ("both", "first_only", "second_only", "neither")
    return Comparison(*(sum(getattr(c, name) for c in comparisons) for name in names))


def verdict_lines(first: Side[TrialResult], second: Side[TrialResult]) -> list[str]:
    """What people want to know: each setting in a line, and all together."""
    settings = compare(first, second)
    keys = ("particle_count", *SETTING)
    varying = [k for k in range(len(keys)) if len({setting[k] for setting in settings}) > 1]
    lines = [f"{first.label} against {second.label}, success in the same worlds:"]
    if len(settings) > 1:
        for setting, comparison in settings.items():
            name = title_of([keys[k] for k in varying], [setting[k] for k in varying])
            lines.append(f"  {name}: {_sentence(comparison)}")
    return [*lines, f"all together: {_sentence(pooled(list(settings.values())))}"]


def _apart(first: Side[TrialResult], second: Side[TrialResult]) -> str:
    """The columns in which no value of one is a value of the other, in words."""
    names = [
        name
        for name in (*SETTING, "seed", "particle_count")
        if {getattr(row, name) for row in first.rows}.isdisjoint(
            getattr(row, name) for row in second.rows
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
