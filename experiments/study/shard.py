"""Parts of a study that run apart, on machines that need not know of each other."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

Job = TypeVar("Job")


@dataclass(frozen=True)
class Shard:
    """One of `count` parts that are disjoint and together the whole study."""

    number: int
    """Which part, from 1 on."""
    count: int

    def __post_init__(self) -> None:
        if not 1 <= self.number <= self.count:
            raise ValueError(f"shard must be I/N with I from 1 to N, got '{self}'")

    def __str__(self) -> str:
        return f"{self.number}/{self.count}"

    @classmethod
    def parse(cls, text: str) -> Shard:
        """The shard that is written as `2/4`; ValueError for anything else."""
        if not re.fullmatch(r"[0-9]+/[0-9]+", text):
            raise ValueError(f"shard must be I/N with I from 1 to N, as 2/4, got {text!r}")
        number, count = text.split("/")
        return cls(int(number), int(count))

    def of(self, jobs: Sequence[Job]) -> list[Job]:
        """The jobs of this part.

        Jobs are dealt out like cards, cell after cell. So no shard has two jobs more than another,
        nor, of its own, two more of one cell than of another; and where the number of shards
        divides that of the seeds, each has whole seeds.
        """
        return list(jobs[self.number - 1 :: self.count])
