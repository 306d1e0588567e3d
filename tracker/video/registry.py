"""The particle filters for videos by name, where size and motion of the target are unknown."""

from dataclasses import replace

from tracker.affine.methods import METHODS
from tracker.video.appearance import AppearanceConfig
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
