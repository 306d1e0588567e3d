"""The trackers that can enter the OTB protocol, by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tracker.box_tracker import BoxTracker, BoxTrackerConfig, TemplateBoxTracker
from tracker.registry import get_tracker_config


@dataclass(frozen=True)
class Contestant:
    """A tracker and how to make a fresh one."""

    description: str
    make: Callable[[np.random.Generator], BoxTracker]
    is_random: bool = True
    """Whether the answer depends on the seed; others run with seed 0 only."""
    settings: str = ""
    """All that determines its answers beside the code; results of other settings do not mix."""


def _particle_filter(name: str) -> Contestant:
    row = get_tracker_config(name)
    base = BoxTrackerConfig()
    parts = {part: getattr(row.filter, part) for part in ("state_space", "proposal", "resampling")}
    config = replace(base, filter=replace(base.filter, **parts))
    return Contestant(
        row.description, lambda rng: TemplateBoxTracker(config, rng), settings=repr(config)
    )


CONTESTANTS: dict[str, Contestant] = {
    name: _particle_filter(name) for name in ("igpf", "gpf", "pf")
}
"""The paper's comparison: identical but for the filter."""
