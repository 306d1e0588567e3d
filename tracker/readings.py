"""Other readings of the paper, and single parts more than it has: one change from a row each.

The displayed equations of [IGPF2021] section 3.1 are lost in the text at hand, and it is silent on
other things. `docs/method.md` compares what these rows measure.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from tracker.particle_box_tracker import BoxTrackerConfig
from tracker.registry import BOX_TRACKERS


def _filter(name: str, description: str, **changes: Any) -> BoxTrackerConfig:
    row = BOX_TRACKERS[name]
    return replace(row, description=description, filter=replace(row.filter, **changes))


def _combination(description: str, **changes: Any) -> BoxTrackerConfig:
    combination = replace(BOX_TRACKERS["igpf"].filter.combination, **changes)
    return _filter("igpf", description, combination=combination)


def _likelihood(name: str, description: str, **changes: Any) -> BoxTrackerConfig:
    row = BOX_TRACKERS[name]
    return replace(row, description=description, likelihood=replace(row.likelihood, **changes))


READINGS: dict[str, BoxTrackerConfig] = {
    "igpf-away": _combination("Eq 24: away from the low particle", direction="away-from-low"),
    "igpf-from-low": _combination("Eq 24: from the low particle", direction="from-low"),
    "igpf-k1": _combination("Eq 24: K = 1, not 0.5", step_gain=1.0),
    "igpf-k2": _combination("Eq 24: K = 2, not 0.5", step_gain=2.0),
    "igpf-dim3": _combination("Eq 25: dim = 3, not 6", dimension=3),
    "igpf-patent": _combination(
        "the patent's split by a threshold and its Gaussian at the best particle",
        low="below-average",
        centre="best",
    ),
    "igpf-estimate": _combination(
        "copies spread with the variance of the last estimate, without process noise",
        spread="estimate",
    ),
    "igpf-early": _filter("igpf", "estimate before resampling", is_estimate_late=False),
    "igpf-iterated": _filter("igpf", "two linearisations an image", iterations=2),
    "gpf-iterated": _filter("gpf", "two linearisations an image", iterations=2),
    "igpf-defensive": _filter("igpf", "30 % of the particles from the prior", prior_share=0.3),
    "gpf-defensive": _filter("gpf", "30 % of the particles from the prior", prior_share=0.3),
    "igpf-local": _likelihood("igpf", "each particle under its own noise", is_local_noise=True),
    "gpf-local": _likelihood("gpf", "each particle under its own noise", is_local_noise=True),
    "igpf-anchored": replace(
        BOX_TRACKERS["igpf"], description="template anchored on its first picture", anchor=0.6
    ),
    "gpf-anchored": replace(
        BOX_TRACKERS["gpf"], description="template anchored on its first picture", anchor=0.6
    ),
}
