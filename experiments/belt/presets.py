"""Named sweeps: cells (what is compared) times seeds (the worlds it is compared in)."""

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

from experiments.belt.config import TrialConfig


@dataclass(frozen=True)
class Preset:
    """A sweep that has a name, so that its results can be named too."""

    name: str
    description: str
    cells: tuple[TrialConfig, ...]
    """One configuration for each cell of the table; their seeds are replaced."""
    seeds: tuple[int, ...]

    def __post_init__(self) -> None:
        if not (self.cells and self.seeds):
            raise ValueError(f"preset {self.name}: cells and seeds must not be empty")
        cells = {replace(cell, seed=0) for cell in self.cells}
        if len(cells) != len(self.cells) or len(set(self.seeds)) != len(self.seeds):
            raise ValueError(f"preset {self.name}: cells and seeds must not repeat")

    def restricted(self, trackers: Sequence[str] = (), seeds: Sequence[int] | None = None) -> Self:
        """The same preset with these trackers and seeds, where any are given.

        A tracker that the preset does not have takes the cells of its first tracker.
        """
        first = self.cells[0].tracker
        cells = [
            replace(cell, tracker=tracker)
            for tracker in trackers
            for cell in self.cells
            if cell.tracker == (tracker if self._has(tracker) else first)
        ]
        return replace(
            self,
            cells=tuple(cells) if trackers else self.cells,
            seeds=self.seeds if seeds is None else tuple(seeds),
        )

    def _has(self, tracker: str) -> bool:
        return any(cell.tracker == tracker for cell in self.cells)


def expand(base: TrialConfig | None = None, **axes: Iterable[Any]) -> tuple[TrialConfig, ...]:
    """The product of list-valued axes, the last one fastest.

    `expand(tracker=["pf", "igpf"], speed_mps=[0.1, 0.25])` gives four cells.
    """
    combinations = itertools.product(*axes.values())
    return tuple(
        replace(base or TrialConfig(), **dict(zip(axes, values, strict=True)))
        for values in combinations
    )


_PAPER_SPEEDS_MPS = (0.10, 0.15, 0.20, 0.25)
"""The belt speeds of [IGPF2021]."""
_SPEEDS_ON_MPS = (0.50, 0.75, 1.00, 1.25)
"""On to where success ends."""

_FILTERS = ("igpf", "gpf", "pf")

_PAPER = (
    expand(tracker=_FILTERS, speed_mps=[*_PAPER_SPEEDS_MPS, *_SPEEDS_ON_MPS])
    + expand(
        tracker=_FILTERS,
        condition=["dark-3", "switch-3", "resolution-2", "resolution-3"],
        speed_mps=[*_PAPER_SPEEDS_MPS, 0.50],
    )
    + expand(TrialConfig(camera="overhead"), tracker=_FILTERS, speed_mps=[*_PAPER_SPEEDS_MPS, 0.50])
    + expand(tracker=["oracle"], speed_mps=[*_PAPER_SPEEDS_MPS, *_SPEEDS_ON_MPS])
)

_STRESS = expand(
    TrialConfig(speed_mps=0.50),
    tracker=_FILTERS,
    condition=[
        *("normal", "dark-4", "switch-4", "flicker-4", "resolution-2", "resolution-3"),
        *("blur-3", "noise-4", "depth-3", "drops-4", "late-3"),
        *("occlusion-4", "clutter-3", "distractors-2"),
    ],
    motion=["constant", "sine", "stop-and-go"],
)
_STRESS_ARMS = expand(
    TrialConfig(speed_mps=0.50),
    tracker=["oracle", "oracle-noisy", "static"],
    motion=["constant", "sine", "stop-and-go"],
)

_PRESETS = (
    Preset(
        "demo",
        "IGPF at three belt speeds, three boxes each: a first look",
        expand(tracker=["igpf"], speed_mps=[0.10, 0.15, 0.25]),
        tuple(range(3)),
    ),
    Preset(
        "smoke",
        "three trials: does everything work on this machine?",
        expand(tracker=["static", "oracle", "igpf"], speed_mps=[0.50]),
        (0,),
    ),
    Preset(
        "loop",
        "the closed loop: IGPF and the oracle up to 1 m/s, 50 boxes a cell",
        expand(tracker=["igpf", "oracle"], speed_mps=[0.10, 0.15, 0.25, 0.50, 1.00]),
        tuple(range(50)),
    ),
    Preset(
        "predictors",
        "each way to bridge the delays, on IGPF and on 2 mm of noise, 5 boxes a cell",
        expand(
            tracker=["igpf", "oracle-noisy"],
            predictor=["kalman", "least-squares", "weighted", "weighted-velocity", "latest"],
            speed_mps=[0.25, 1.00],
        ),
        tuple(range(5)),
    ),
    Preset(
        "paper",
        "Tables 3, 5, 6 of [IGPF2021]: filters, light, resolution, overhead; 50 boxes a cell",
        _PAPER,
        tuple(range(50)),
    ),
    Preset(
        "real-cell",
        "Table 4 of [IGPF2021]: UR3, soft gripper, Kinect v2; filters and oracle, 50 boxes a cell",
        expand(
            TrialConfig(embodiment="ur3-soft", camera="kinect", condition="kinect-1"),
            tracker=["igpf", "gpf", "pf", "oracle"],
            speed_mps=[0.10, 0.15, 0.25],
        ),
        tuple(range(50)),
    ),
    Preset(
        "speed",
        "up to where success ends: filters and control arms to 1.5 m/s, 30 boxes a cell",
        expand(
            tracker=["igpf", "gpf", "pf", "static", "oracle", "oracle-noisy"],
            speed_mps=[0.10, 0.25, 0.50, 0.75, 1.00, 1.25, 1.50],
        ),
        tuple(range(30)),
    ),
    Preset(
        "stress",
        "what tells trackers apart: bad conditions on three belt motions, 20 boxes a cell",
        _STRESS + _STRESS_ARMS,
        tuple(range(20)),
    ),
    Preset(
        "filters",
        "PF, GPF and IGPF beside the control arms up to 1 m/s, 20 boxes a cell",
        expand(
            tracker=["pf", "gpf", "igpf", "static", "oracle", "oracle-noisy"],
            speed_mps=[0.10, 0.25, 0.50, 1.00],
        ),
        tuple(range(20)),
    ),
)

PRESETS: dict[str, Preset] = {preset.name: preset for preset in _PRESETS}
"""Every named sweep."""
