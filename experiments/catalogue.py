"""Every name a user can give, with one line about it, read from the registries."""

from collections.abc import Mapping
from functools import cache
from typing import Any

from experiments.belt.presets import PRESETS


@cache
def catalogue() -> dict[str, dict[str, str]]:
    """Kind -> name -> description; imports the simulation, so it takes a second."""
    from experiments.bearing_only.controllers import CONTROLLERS
    from experiments.belt.perception import CONTROL_ARMS
    from experiments.video.protocols import PROTOCOLS
    from experiments.video.trackers import VIDEO_TRACKERS
    from sim.arm.embodiments import EMBODIMENTS
    from sim.belt.objects import OBJECTS
    from sim.belt.scenario import MOTIONS
    from sim.imaging.camera import CAMERAS
    from sim.imaging.degradations import DEGRADATIONS, NORMAL
    from tracker.belt.prediction import PREDICTORS
    from tracker.belt.registry import TRACKERS
    from tracker.video.registry import VARIANTS

    videos = {name: entry for name, entry in VIDEO_TRACKERS.items() if name not in VARIANTS}
    return {
        "trackers": _descriptions(TRACKERS),
        "control arms": _descriptions(CONTROL_ARMS),
        "peers": _peers(),
        "embodiments": _descriptions(EMBODIMENTS),
        "cameras": _descriptions(CAMERAS),
        "objects": _descriptions(OBJECTS),
        "motions": _descriptions(MOTIONS),
        "conditions": {NORMAL: "bright even light, 640 x 480, noise of 2 levels and 2 mm"}
        | {
            f"{name}-1" + (f" to -{count}" if (count := len(entry.levels)) > 1 else ""): (
                entry.description
            )
            for name, entry in DEGRADATIONS.items()
        },
        "predictors": _descriptions(PREDICTORS),
        "presets": _descriptions(PRESETS),
        "video trackers": _descriptions(videos),
        "variants, for video": _descriptions(VARIANTS),
        "protocols": _descriptions(PROTOCOLS),
        "controllers, for bearing-only": _descriptions(CONTROLLERS),
    }


def _descriptions(registry: Mapping[str, Any]) -> dict[str, str]:
    return {name: entry.description for name, entry in registry.items()}


def _peers() -> dict[str, str]:
    from tracker.peers.baselines import BASELINES

    return {
        name: row.description if row.is_available else f"{row.description} (needs `make peers`)"
        for name, row in BASELINES.items()
    }
