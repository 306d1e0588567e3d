"""Parts of a sweep that run apart, on machines that need not know of each other."""

from __future__ import annotations

import re
from dataclasses import dataclass


@dataclass(frozen=True)
class Shard:
    """One of `count` parts that are disjoint and together the whole sweep."""

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

    def places(self, cell_count: int, seed_count: int) -> list[int]:
        """Which trials are this shard's, as indices into the sweep, all cells at one seed first.

        The trials are dealt out like cards, cell after cell. So no shard has two trials more than
        another, nor, of its own, two more of one cell than of another; and where the number of
        shards divides that of the seeds, each has whole seeds.
        """
        return [
            seed * cell_count + cell
            for seed in range(seed_count)
            for cell in range(cell_count)
            if (cell * seed_count + seed) % self.count == self.number - 1
        ]
