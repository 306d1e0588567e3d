"""When a track counts as supported by the image, as uncertain or as lost."""

from dataclasses import dataclass

from tracker.checks import require_count, require_positive, require_share


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
