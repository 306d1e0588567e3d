"""Results on video sequences as tables want them: the curves of every tracker on every sequence."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from experiments.study.study import Key, Results
from experiments.video.job import AFFINE, HITS, KEY, VideoRow
from experiments.video.protocols import PROTOCOLS
from experiments.video.scores import Curves, mean_curves
from experiments.video.trackers import VIDEO_TRACKERS


@dataclass(frozen=True, eq=False)
class OtbResults:
    """What a results folder holds."""

    path: Path
    names: list[str]
    """Sequences in alphabetical order."""
    attributes: dict[str, tuple[str, ...]]
    """Sequence -> challenges."""
    curves: dict[tuple[str, str, str], Curves]
    """(protocol, tracker, sequence) -> curves, the mean over the seeds."""
    seeds: dict[tuple[str, str, str], tuple[int, ...]]
    affine: dict[Key, str]
    """(protocol, sequence, tracker, seed) -> lines of affine errors; empty where there are none."""

    @classmethod
    def collect(cls, results: Results[VideoRow]) -> Self:
        """The results in the rows and curves of a folder; jobs that crashed are left out."""
        by_seed: dict[tuple[str, str, str], dict[int, Curves]] = {}
        for row in results.good:
            key = row.protocol, row.sequence, row.tracker, str(row.seed)
            hits = results.curves[HITS][key].rstrip("\n").split(",")[len(KEY) :]
            curves = Curves.of_hits([int(hit) for hit in hits], row.frame_count)
            by_seed.setdefault((row.protocol, row.tracker, row.sequence), {})[row.seed] = curves
        attributes = {row.sequence: tuple(row.attributes.split()) for row in results.good}
        return cls(
            path=results.path,
            names=sorted(attributes),
            attributes=attributes,
            curves={key: mean_curves(list(seeds.values())) for key, seeds in by_seed.items()},
            seeds={key: tuple(sorted(seeds)) for key, seeds in by_seed.items()},
            affine=results.curves[AFFINE],
        )

    @property
    def protocols(self) -> list[str]:
        """Those that were run, in the usual order."""
        found = {protocol for protocol, _, _ in self.curves}
        return [name for name in PROTOCOLS if name in found]

    def trackers(self, protocol: str) -> list[str]:
        """Those that were run by this protocol, in the order of their registry."""
        found = {tracker for name, tracker, _ in self.curves if name == protocol}
        return [*(n for n in VIDEO_TRACKERS if n in found), *sorted(found - set(VIDEO_TRACKERS))]

    def sequences(self, protocol: str, attribute: str | None = None) -> list[str]:
        """Those that every tracker of the protocol has finished: means are over the same ones."""
        trackers = self.trackers(protocol)
        return [
            name
            for name in self.names
            if all((protocol, tracker, name) in self.curves for tracker in trackers)
            and (attribute is None or attribute in self.attributes[name])
        ]

    def left_out(self, protocol: str) -> list[str]:
        """Sequences that some trackers of the protocol have finished and others have not."""
        some = {name for found, _, name in self.curves if found == protocol}
        return sorted(some - set(self.sequences(protocol)))

    def affine_of(self, protocol: str, tracker: str) -> list[str]:
        """Lines of the affine errors of one tracker, seed after seed."""
        keys = [key for key in self.affine if (key[0], key[2]) == (protocol, tracker)]
        keys.sort(key=lambda key: (key[3], key[1]))
        return [line for key in keys for line in self.affine[key].splitlines()]

    def of(self, protocol: str, tracker: str, sequences: Sequence[str]) -> list[Curves]:
        """The curves of one tracker on these sequences."""
        return [self.curves[protocol, tracker, name] for name in sequences]
