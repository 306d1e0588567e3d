"""The particle filters for videos by name, where size and motion of the target are unknown."""

from dataclasses import replace
from typing import Any, cast

from tracker.affine.filter import METHODS
from tracker.video.appearance import AppearanceConfig, SubspaceConfig
from tracker.video.guide import GuideConfig
from tracker.video.particle_box_tracker import VIDEO_FILTER, VIDEO_LIKELIHOOD, BoxTrackerConfig
from tracker.video.redetection import RedetectionConfig
from tracker.video.refinement import RefinementConfig

BOX_TRACKERS: dict[str, BoxTrackerConfig] = {
    **{
        name: BoxTrackerConfig(method.description, filter=method.applied_to(VIDEO_FILTER))
        for name, method in METHODS.items()
    },
    "igpf-best": BoxTrackerConfig(
        description="igpf with all that helped: guide, anchored template, re-detection, refinement",
        filter=replace(
            METHODS["igpf"].applied_to(VIDEO_FILTER),
            noise_per_root_s=(0.015, 0.003, 0.06, 0.003, 0.08, 0.08),
        ),
        likelihood=replace(VIDEO_LIKELIHOOD, is_local_noise=True),
        guide=GuideConfig(),
        appearance=AppearanceConfig(blurs=(0.06,), anchor=0.6),
        redetection=RedetectionConfig(),
        refinement=RefinementConfig(),
    ),
}
"""The first three are the comparison of [IGPF2021] to the letter of its Algorithm 1, identical but
for the filter."""


def _variant(name: str, description: str, **changes: Any) -> BoxTrackerConfig:
    return _changed(BOX_TRACKERS[name], {"description": description, **changes})


def _changed(config: Any, changes: dict[str, Any]) -> Any:
    """`config` with fields replaced; a dictionary changes the fields of a field."""
    changed = dict(changes)
    for name, value in changes.items():
        if isinstance(value, dict):
            changed[name] = _changed(getattr(config, name), cast(dict[str, Any], value))
    return replace(config, **changed)


def _combination(description: str, **changes: Any) -> BoxTrackerConfig:
    return _variant("igpf", description, filter={"combination": changes})


_PARTS: dict[str, tuple[str, dict[str, Any]]] = {
    "iterated": ("two linearisations an image", {"filter": {"iterations": 2}}),
    "pyramid": (
        "two linearisations an image, the first one of a blurred picture",
        {"filter": {"iterations": 2}, "appearance": {"blurs": (0.2, 0.1)}},
    ),
    "families": ("five particles share a linearisation", {"filter": {"family_size": 5}}),
    "defensive": ("30 % of the particles from the prior", {"filter": {"prior_share": 0.3}}),
    "local": ("each particle under its own noise", {"likelihood": {"is_local_noise": True}}),
    "anchored": ("template anchored on its first picture", {"appearance": {"anchor": 0.6}}),
    "subspace": (
        "variations of the template cost nothing",
        {"appearance": {"subspace": SubspaceConfig()}},
    ),
    "redetecting": ("looks for a lost target", {"redetection": RedetectionConfig()}),
    "refined": ("Gauss-Newton steps under less blur", {"refinement": RefinementConfig()}),
}
"""Parts that the paper does not have; each runs with either filter."""

_BEST = BOX_TRACKERS["igpf-best"]

VARIANTS: dict[str, BoxTrackerConfig] = {
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
    "igpf-early": _variant(
        "igpf", "estimate before resampling", filter={"is_estimate_late": False}
    ),
    **{
        f"{name}-best": replace(
            _BEST,
            description=f"igpf-best with the filter of {name}",
            filter=METHODS[name].applied_to(_BEST.filter),
        )
        for name in ("gpf", "pf")
    },
    **{
        f"{name}-{part}": _variant(name, description, **changes)
        for part, (description, changes) in _PARTS.items()
        for name in ("igpf", "gpf")
    },
}
"""Variants of these rows: other readings of the paper, or one part more than it has.

The displayed equations of [IGPF2021] section 3.1 are lost in the text at hand, and it is silent on
other things. `docs/method.md` compares what these rows measure.
"""
