"""The trackers of the belt by name; the rows differ only where the methods do."""

from dataclasses import dataclass, field, replace
from typing import Self

from tracker.affine.filter import METHODS, FilterConfig
from tracker.affine.likelihood import LikelihoodConfig
from tracker.belt.backproject import BackprojectConfig
from tracker.belt.detection import DetectionConfig
from tracker.checks import require_count, require_known, require_positive, require_share
from tracker.peers.baselines import BASELINES
from tracker.peers.outside import get_box_finder, is_outside


@dataclass(frozen=True)
class StatusConfig:
    """Thresholds of a tracker's judgement of its own estimate."""

    tracking_ncc: float = 0.75
    """Correlation from which the image supports the estimate."""
    lost_ncc: float = 0.45
    """Correlation under which a well visible target is not where the estimate says."""
    lost_image_count: int = 3
    """Images in a row under `lost_ncc` until the target counts as lost."""
    min_visible_fraction: float = 0.25
    """Visible share of the template under which the correlation proves nothing."""
    max_hidden_s: float = 1.0
    """Time without support by the image after which the target counts as lost."""

    def __post_init__(self) -> None:
        require_share(self, "tracking_ncc", "lost_ncc", "min_visible_fraction")
        if self.lost_ncc > self.tracking_ncc:
            raise ValueError(f"lost_ncc must not exceed tracking_ncc, got {self.lost_ncc!r}")
        require_count(self, "lost_image_count")
        require_positive(self, "max_hidden_s")


@dataclass(frozen=True)
class TrackerConfig:
    """Everything that determines a tracker except its random stream."""

    description: str
    """One line for listings."""
    filter: FilterConfig = field(default_factory=FilterConfig)
    """State space, proposal and resampling: where PF, GPF and IGPF differ."""
    likelihood: LikelihoodConfig = field(default_factory=LikelihoodConfig)
    """Photometric noise model."""
    detection: DetectionConfig = field(default_factory=DetectionConfig)
    """Initialisation and re-detection."""
    status: StatusConfig = field(default_factory=StatusConfig)
    """When the track counts as uncertain or lost."""
    backproject: BackprojectConfig = field(default_factory=BackprojectConfig)
    """Reconstruction of the pose."""
    is_static: bool = False
    """Hold the first detection instead of tracking."""
    baseline: str = ""
    """What follows the target instead of the filter: a row of BASELINES or an import path."""
    max_speed_mps: float = 3.0
    """Two detections that would need more than this are not the same target."""

    def __post_init__(self) -> None:
        require_positive(self, "max_speed_mps")

    def with_particle_count(self, particle_count: int) -> Self:
        """The same tracker with another number of particles."""
        return replace(self, filter=replace(self.filter, particle_count=particle_count))


TRACKERS: dict[str, TrackerConfig] = {
    **{
        name: TrackerConfig(method.description, filter=method.applied_to(FilterConfig()))
        for name, method in METHODS.items()
    },
    "static": TrackerConfig(
        description="control: holds the first detection and never moves", is_static=True
    ),
}
"""The methods of [IGPF2021] with what is known on the belt, and the control arm."""

PEERS: dict[str, TrackerConfig] = {
    name: TrackerConfig(description=baseline.description, baseline=name)
    for name, baseline in BASELINES.items()
}
"""What people would pick instead, with the same detection and reconstruction."""


def get_tracker_config(name: str) -> TrackerConfig:
    """The named configuration, a peer's or that of a tracker from outside among them.

    Raises ValueError that lists the valid names and suggests the nearest.
    """
    if is_outside(name):
        return TrackerConfig(description=get_box_finder(name).description, baseline=name)
    rows = TRACKERS | PEERS
    require_known("tracker", name, rows)
    return rows[name]
