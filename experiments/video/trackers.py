"""The trackers that can run on video sequences, by name."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from experiments.study.settings import digest
from tracker.box_tracker import BoxTracker
from tracker.checks import require_known
from tracker.peers.baselines import BASELINES, Baseline
from tracker.peers.outside import get_box_finder, is_outside, outside_source
from tracker.video.particle_box_tracker import BoxTrackerConfig, ParticleBoxTracker
from tracker.video.registry import BOX_TRACKERS, VARIANTS


@dataclass(frozen=True)
class VideoTracker:
    """A tracker of boxes and how to make a fresh one."""

    description: str
    make: Callable[[np.random.Generator], BoxTracker]
    is_random: bool = True
    """Whether the answer depends on the seed; others run with seed 0 only."""
    settings: object = None
    """All that determines its answers beside the code; results of other settings do not mix."""


def _particle_filter(config: BoxTrackerConfig) -> VideoTracker:
    return VideoTracker(
        config.description, lambda rng: ParticleBoxTracker(config, rng), settings=config
    )


def _peer(baseline: Baseline) -> VideoTracker:
    return VideoTracker(baseline.description, baseline.make, baseline.is_random)


def get_video_tracker(name: str) -> VideoTracker:
    """The row of that name, or the tracker at that import path; ValueError for neither."""
    if is_outside(name):
        found = get_box_finder(name)
        source = digest(outside_source(name).encode())
        return VideoTracker(found.description, found.make, settings={"source": source})
    require_known("tracker", name, VIDEO_TRACKERS)
    return VIDEO_TRACKERS[name]


VIDEO_TRACKERS: dict[str, VideoTracker] = {
    **{name: _particle_filter(config) for name, config in BOX_TRACKERS.items()},
    **{name: _peer(baseline) for name, baseline in BASELINES.items()},
    **{name: _particle_filter(config) for name, config in VARIANTS.items()},
}
"""The first three are the paper's comparison, identical but for the filter; then come igpf with all
that helped, the trackers that people would pick instead, and other readings of the paper."""
