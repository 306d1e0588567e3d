"""Conditions under which the camera looks at the belt: degradations in levels, alone or together.

Light and what stands in the way are changed in the scene, not in the pixels; noise, drops and
delays are the sensor's.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

from sim.checks import look_up, require, require_at_least, require_within
from sim.imaging.time_of_flight import TimeOfFlight
from sim.world_config import PHYSICS_HZ

WIDEST_BAR_M = 0.5
LOOK_ALIKE_COUNT = 3
"""So many are in the compiled model."""
BRIGHTEST = 2.0

Light: TypeAlias = Callable[[float, float], float]
"""Brightness of every lamp, 1 being the normal one, at a time [s] and while the target is at a
place along the belt [m]."""


@dataclass(frozen=True)
class SteadyLight:
    """Light that does not change."""

    scale: float = 1.0

    def __post_init__(self) -> None:
        require_within(self, 0.0, BRIGHTEST, "scale")

    def __call__(self, time_s: float, target_y_m: float) -> float:
        """Returns the same brightness at any time."""
        return self.scale


@dataclass(frozen=True)
class SwitchedLight:
    """Light that is switched while the target is under way."""

    before: float
    after: float
    at_y_m: float = -0.72
    """Where the target is then: all of it has come into view, and the hand is on its way to it."""

    def __post_init__(self) -> None:
        require_within(self, 0.0, BRIGHTEST, "before", "after")

    def __call__(self, time_s: float, target_y_m: float) -> float:
        """Returns the brightness before or after the switch."""
        return self.before if target_y_m < self.at_y_m else self.after


@dataclass(frozen=True)
class FlickeringLight:
    """Lamps on the mains: twice its frequency, which a camera at 30 Hz sees as a slow beat."""

    depth: float
    """Amplitude as a share of the mean."""
    rate_hz: float = 100.0

    def __post_init__(self) -> None:
        require_within(self, 0.0, 1.0, "depth")

    def __call__(self, time_s: float, target_y_m: float) -> float:
        """Returns the brightness at that moment."""
        return 1.0 + self.depth * math.sin(2.0 * math.pi * self.rate_hz * time_s)


@dataclass(frozen=True)
class Condition:
    """A state of the light, the sensor and the surroundings; the default is the normal one."""

    light: Light = field(default_factory=SteadyLight)
    shadows: bool = False
    """Whether the key light casts shadows; doubles the cost of a frame."""
    width_px: int = 640
    height_px: int = 480
    exposure_s: float = 0.0
    """How long the shutter is open; 0 for an instant."""
    colour_noise_std: float = 2.0
    """Noise of reading a pixel, in grey levels of 255."""
    full_well_e: float = math.inf
    """Electrons of a pixel at level 255, which decide the shot noise; infinite for none."""
    depth_noise_std_m: float = 0.002
    depth_hole_share: float = 0.0
    """Share of the depth pixels without a return, in blots."""
    time_of_flight: TimeOfFlight | None = None
    """Depth errors that follow the scene, before `depth_noise_std_m`; None for none."""
    dropped_share: float = 0.0
    """Probability that an image never arrives."""
    late_share: float = 0.0
    """Probability that an image arrives `late_s` later than the declared delay says."""
    late_s: float = 0.0
    bar_m: float = 0.0
    """Width of a bar half-way between the camera and the belt; 0 for none. It hides twice that."""
    clutter: float = 0.0
    """Opacity of a busy print on belt, rails and floor."""
    look_alike_count: int = 0
    """Mirror images of the object that ride along."""

    def __post_init__(self) -> None:
        require_at_least(self, 16, "width_px", "height_px")
        require_at_least(self, 0.0, "exposure_s", "colour_noise_std", "depth_noise_std_m", "late_s")
        require_within(self, 0.0, WIDEST_BAR_M, "bar_m")
        require_within(self, 0.0, 1.0, "clutter")
        counts = range(LOOK_ALIKE_COUNT + 1)
        require(self, f"0 to {counts[-1]}", counts.__contains__, ["look_alike_count"])
        require(self, "greater than 0", lambda v: v > 0.0, ["full_well_e"])
        shares = "depth_hole_share", "dropped_share", "late_share"
        require(self, "from 0 to below 1", lambda v: 0.0 <= v < 1.0, shares)


@dataclass(frozen=True)
class Degradation:
    """One thing that gets worse level by level; level 0 is the normal condition."""

    description: str
    levels: tuple[Mapping[str, Any], ...]
    """Fields of `Condition` from level 1 on."""


_SHOT = {"full_well_e": 4000.0}
"""A small sensor: its shot noise is 8 levels at 255, and 4 at 64."""

DEGRADATIONS: dict[str, Degradation] = {
    "dark": Degradation(
        "50, 25, 15, 8 % of the light, with shot noise",
        tuple({"light": SteadyLight(scale), **_SHOT} for scale in (0.50, 0.25, 0.15, 0.08)),
    ),
    "switch": Degradation(
        "light switched to 50, 25, 15, 8 % while the hand is on its way, with shot noise",
        tuple({"light": SwitchedLight(1.0, scale), **_SHOT} for scale in (0.50, 0.25, 0.15, 0.08)),
    ),
    "flicker": Degradation(
        "light that flickers by 20, 40, 60, 80 % at 100 Hz",
        tuple({"light": FlickeringLight(depth)} for depth in (0.2, 0.4, 0.6, 0.8)),
    ),
    "shadows": Degradation("the key light casts shadows", ({"shadows": True},)),
    "resolution": Degradation(
        "320 x 240, 160 x 120, 80 x 60 pixels",
        tuple({"width_px": 640 >> k, "height_px": 480 >> k} for k in (1, 2, 3)),
    ),
    "blur": Degradation(
        "shutter open for 8, 17, 33 ms",
        tuple({"exposure_s": count / PHYSICS_HZ} for count in (4, 8, 16)),
    ),
    "noise": Degradation(
        "colour noise of 5, 10, 20, 40 levels",
        tuple({"colour_noise_std": std} for std in (5.0, 10.0, 20.0, 40.0)),
    ),
    "depth": Degradation(
        "depth noise of 4, 8, 16 mm with 2, 10, 30 % of holes",
        tuple(
            {"depth_noise_std_m": std_m, "depth_hole_share": share}
            for std_m, share in ((0.004, 0.02), (0.008, 0.10), (0.016, 0.30))
        ),
    ),
    "kinect": Degradation(
        "the depth image of a Kinect v2: 512 x 424, noise by distance and angle, flying pixels",
        (
            {
                "width_px": 512,
                "height_px": 424,
                "depth_noise_std_m": 0.0,
                "time_of_flight": TimeOfFlight(),
            },
        ),
    ),
    "drops": Degradation(
        "10, 30, 50, 70 % of the images never arrive",
        tuple({"dropped_share": share} for share in (0.1, 0.3, 0.5, 0.7)),
    ),
    "late": Degradation(
        "a fifth of the images is 33, 67, 133 ms late",
        tuple({"late_share": 0.2, "late_s": late / 30} for late in (1, 2, 4)),
    ),
    "occlusion": Degradation(
        "a bar hides 8, 16, 24, 32 cm of the belt before the hand's reach",
        tuple({"bar_m": width_m} for width_m in (0.04, 0.08, 0.12, 0.16)),
    ),
    "clutter": Degradation(
        "busy print on belt, rails and floor, 35, 70, 100 % opaque",
        tuple({"clutter": opacity} for opacity in (0.35, 0.7, 1.0)),
    ),
    "distractors": Degradation(
        "1, 2, 3 mirror images of the object ride along, 39 cm apart",
        tuple({"look_alike_count": count} for count in (1, 2, 3)),
    ),
}
"""Everything that can get worse; a condition names one by its level, as in `dark-3`."""

NORMAL = "normal"


def get_condition(name: str) -> Condition:
    """The condition of a name: `normal`, `dark-3`, or several as in `dark-3+resolution-1`.

    Raises ValueError for what no degradation has, and for two that change the same thing.
    """
    condition, changed = Condition(), dict[str, str]()
    for part in name.split("+") if name != NORMAL else ():
        for key, value in _level(part).items():
            if key in changed and value != getattr(condition, key):
                raise ValueError(f"condition {name!r}: {changed[key]} and {part} both set {key}")
            changed[key] = part
            condition = replace(condition, **{key: value})
    return condition


def _level(part: str) -> Mapping[str, Any]:
    """What one degradation at one level changes."""
    name, _, number = part.rpartition("-")
    if not (name and number.isdecimal()):
        raise ValueError(
            f"condition must be {NORMAL}, or NAME-LEVEL with a NAME of {', '.join(DEGRADATIONS)}, "
            f"or several joined by +; got {part!r}"
        )
    levels = look_up("degradation", name, DEGRADATIONS).levels
    if int(number) > len(levels):
        raise ValueError(f"condition: {name} has levels 0 to {len(levels)}, got {part!r}")
    return levels[int(number) - 1] if int(number) else {}
