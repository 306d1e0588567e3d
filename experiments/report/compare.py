"""Two methods on the same tasks: which is better, by how much, and how sure that is."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.report.statistics import SIGNIFICANCE, bootstrap, mcnemar_exact, mean_difference
from experiments.report.table import show_p


@dataclass(frozen=True)
class Method:
    """A method and its scores."""

    name: str
    scores: Mapping[Any, float | None]
    """Task, such as a setting and a seed, -> score; None or NaN where it has none."""


@dataclass(frozen=True)
class Scale:
    """What a score means."""

    name: str
    """What is measured, such as `axis error`."""
    unit: str = ""
    higher_is_better: bool = False
    digits: int = 2


def compare_scores(
    first: Method, second: Method, scale: Scale, rng: np.random.Generator
) -> list[str]:
    """Compares two methods on the tasks that both have a score of.

    The interval of the mean difference is 95 %, BCa, with tasks drawn in pairs [Efron1987]. The
    sign test [Dixon1946] is exact and leaves out ties; it decides, unless the means say otherwise.

    Args:
        first: A method.
        second: The other.
        scale: What the scores mean.
        rng: Draws the tasks of the bootstrap.

    Returns:
        Lines for people, the last of which is the verdict.

    Raises:
        ValueError: If the two have no scored task in common.
    """
    pairs = [
        (score, second.scores[task])
        for task, score in first.scores.items()
        if _is_known(score) and _is_known(second.scores.get(task))
    ]
    if not pairs:
        raise ValueError(f"{first.name} and {second.name} have no {scale.name} of a common task")
    ours, theirs = np.array(pairs, float).T
    gains = ours - theirs if scale.higher_is_better else theirs - ours
    better, worse = int((gains > 0).sum()), int((gains < 0).sum())
    p = mcnemar_exact(better, worse)
    means = [f"{scores.mean():.{scale.digits}f}" for scores in (ours, theirs)]
    found = bootstrap(mean_difference, rng, ours, theirs)
    difference, low, high = (f"{value:+.{scale.digits}f}" for value in found)
    unit = f" [{scale.unit}]" if scale.unit else ""
    return [
        f"{first.name} against {second.name}, {scale.name}{unit}, "
        f"{'higher' if scale.higher_is_better else 'lower'} is better, {len(pairs)} pairs:",
        f"  means: {means[0]} and {means[1]}, difference {difference} [{low}, {high}]",
        f"  {first.name} is better in {better}, equal in {len(pairs) - better - worse}, "
        f"worse in {worse}; sign test p {show_p(p)}",
        _verdict(first.name if better > worse else second.name, p, gains.mean() * (better - worse)),
    ]


def _is_known(score: float | None) -> bool:
    return score is not None and not math.isnan(score)


def _verdict(name: str, p: float, agreement: float) -> str:
    """Names who is better more often, where that is no accident and the means do not object."""
    if p >= SIGNIFICANCE:
        return "no difference shown"
    return f"{name} is better" + ("" if agreement > 0 else " more often, but not in the mean")
