"""The trackers that can enter the OTB protocol, by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from experiments.catalogue import require_known
from tracker.belt.registry import BOX_TRACKERS
from tracker.box_tracker import BoxTracker
from tracker.peers.baselines import BASELINES, Baseline
from tracker.peers.outside import get_box_finder, is_outside, source_of
from tracker.video.particle_box_tracker import BoxTrackerConfig, ParticleBoxTracker
from tracker.video.readings import READINGS


@dataclass(frozen=True)
class Contestant:
    """A tracker and how to make a fresh one."""

    description: str
    make: Callable[[np.random.Generator], BoxTracker]
    is_random: bool = True
    """Whether the answer depends on the seed; others run with seed 0 only."""
    settings: str = ""
    """All that determines its answers beside the code; results of other settings do not mix."""


def _particle_filter(config: BoxTrackerConfig) -> Contestant:
    return Contestant(
        config.description, lambda rng: ParticleBoxTracker(config, rng), settings=repr(config)
    )


def _peer(baseline: Baseline) -> Contestant:
    return Contestant(baseline.description, baseline.make, baseline.is_random)


def get_contestant(name: str) -> Contestant:
    """The row of that name, or the tracker at that import path; ValueError for neither."""
    if is_outside(name):
        found = get_box_finder(name)
        return Contestant(found.description, found.make, settings=source_of(name))
    require_known("tracker", name, CONTESTANTS)
    return CONTESTANTS[name]


CONTESTANTS: dict[str, Contestant] = {
    **{name: _particle_filter(config) for name, config in BOX_TRACKERS.items()},
    **{name: _peer(baseline) for name, baseline in BASELINES.items()},
    **{name: _particle_filter(config) for name, config in READINGS.items()},
}
"""The first three are the paper's comparison, identical but for the filter; then come igpf with all
that helped, the trackers that people would pick instead, and other readings of the paper."""
