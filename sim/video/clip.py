"""What a film shows: target, other actors, light, camera and how they move.

Lengths in the image are those of the unturned camera, for an actor that has not come nearer yet.
Motion is smooth and band-limited: terms are written down, signals are drawn from them. Time is
counted in frames from the first one, and is real: an exposure lasts a part of a frame.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from sim.checks import require_at_least, require_within

WIDTH_PX, HEIGHT_PX = 320, 240
FOCAL_PX = 300.0
"""Distance of the projection centre from the image."""
WALL_DEPTH_M = 4.0
"""Distance of the scenery, a flat wall, from the camera."""
SHORTEST_SIDE_PX = 8.0

Shape = Literal["panel", "carton", "sheet"]
Artwork = Literal["poster", "look-alike", "pole"]
Scenery = Literal["shelves", "bricks", "leaves", "gallery"]

Signal = Callable[[float], float]
"""A value as a function of the time [frames]; 0 at time 0."""

_TONES = 3
_CHECKS_PER_FRAME = 8


class Term(Protocol):
    """A part of a motion, before its random numbers are drawn."""

    def draw(self, frame_count: int, rng: np.random.Generator) -> Signal:
        """The signal for a film of `frame_count` frames."""
        ...


Terms = tuple[Term, ...]
"""The sum of some terms; none is a standstill."""


@dataclass(frozen=True)
class Wave:
    """Three sinusoids of random phase, scaled so that the film contains the peak exactly."""

    peak: float
    """The value farthest from the start, with its sign; the other side goes no farther."""
    periods: tuple[float, float]
    """Shortest and longest period [frames]."""

    def __post_init__(self) -> None:
        _require_periods(self.periods)

    def draw(self, frame_count: int, rng: np.random.Generator) -> Signal:
        """See `Term`."""
        shortest, longest = (float(log) for log in np.log(self.periods))
        edges = np.linspace(shortest, longest, _TONES + 1)
        rates = 2.0 * np.pi / np.exp(rng.uniform(edges[:-1], edges[1:]))
        phases = rng.uniform(0.0, 2.0 * np.pi, _TONES)
        sizes = rng.uniform(0.5, 1.0, _TONES) / rates**0.5

        def tones(times: np.ndarray | float) -> np.ndarray:
            return np.sin(np.multiply.outer(times, rates) + phases) @ sizes

        start = tones(0.0)
        times = np.arange(_CHECKS_PER_FRAME * (frame_count - 1) + 1) / _CHECKS_PER_FRAME
        values = tones(times) - start
        scale = self.peak / values[np.argmax(np.abs(values))]
        return lambda time: float(scale * (tones(time) - start))


@dataclass(frozen=True)
class Swing:
    """A swing to the peak and back, again and again, never beyond either end."""

    peak: float
    """The far end, with its sign."""
    periods: tuple[float, float]
    """Range of the period [frames]."""

    def __post_init__(self) -> None:
        _require_periods(self.periods)

    def draw(self, frame_count: int, rng: np.random.Generator) -> Signal:
        """See `Term`."""
        rate = 2.0 * np.pi / rng.uniform(*self.periods)
        return lambda time: 0.5 * self.peak * (1.0 - math.cos(rate * time))


@dataclass(frozen=True)
class Trip:
    """A trip away and back after a stay, with smooth starts and stops; nothing in it is random."""

    by: float
    """How far it goes."""
    leave: float
    """When it starts to go [frames]."""
    back: float
    """When it starts to come back [frames]."""
    ramp: float
    """How long each way takes [frames]."""

    def __post_init__(self) -> None:
        if not (0.0 < self.ramp and 0.0 <= self.leave <= self.back):
            raise ValueError(
                f"leave, back, ramp must be 0 <= leave <= back and ramp > 0, got "
                f"{self.leave}, {self.back}, {self.ramp}"
            )

    def draw(self, frame_count: int, rng: np.random.Generator) -> Signal:
        """See `Term`."""
        ramp = self.ramp
        return lambda time: (
            self.by
            * (_smooth_step((time - self.leave) / ramp) - _smooth_step((time - self.back) / ramp))
        )


def draw_sum(terms: Terms, frame_count: int, rng: np.random.Generator) -> Signal:
    """Returns the sum of the drawn terms."""
    signals = [term.draw(frame_count, rng) for term in terms]
    return lambda time: math.fsum(signal(time) for signal in signals)


def _require_periods(periods: tuple[float, float]) -> None:
    if not 0.0 < periods[0] <= periods[1]:
        raise ValueError(f"periods must be (short, long), both above 0, got {periods}")


def _smooth_step(x: float) -> float:
    """0 up to x = 0, 1 from x = 1, with continuous acceleration between."""
    x = min(max(x, 0.0), 1.0)
    return x**3 * (10.0 - 15.0 * x + 6.0 * x**2)


@dataclass(frozen=True)
class Moves:
    """How an actor leaves the pose that it starts in, square-on to the camera and flat."""

    x_px: Terms = ()
    """Shift to the right."""
    y_px: Terms = ()
    """Shift downwards."""
    zoom_octaves: Terms = ()
    """Approach to the camera; 1 doubles the size in the image."""
    roll_rad: Terms = ()
    """Turn in the image plane, clockwise as seen."""
    yaw_rad: Terms = ()
    """Turn about the vertical."""
    pitch_rad: Terms = ()
    """Turn about the horizontal."""
    bend_rad: Terms = ()
    """Angle between the left and right edge of a sheet that is rolled onto a cylinder."""
    ripple: Terms = ()
    """Height of the waves that run along a sheet, as a share of its width."""
    sway: Terms = ()
    """How far the plane of a sheet is pulled into an S, as a share of its size."""


@dataclass(frozen=True)
class Actor:
    """A thing in front of the scenery."""

    size_px: tuple[float, float]
    """Width and height in the image at the start."""
    start_px: tuple[float, float] = (0.5 * (WIDTH_PX - 1), 0.5 * (HEIGHT_PX - 1))
    """Where its centre is in the image at the start, from 0."""
    depth_m: float = 1.5
    """Distance of its front from the camera at the start."""
    moves: Moves = Moves()
    shape: Shape = "panel"
    artwork: Artwork = "poster"
    thickness: float = 0.4
    """Depth of a carton, as a share of its width."""

    def __post_init__(self) -> None:
        if min(self.size_px) < SHORTEST_SIDE_PX:
            raise ValueError(
                f"size_px must be at least {SHORTEST_SIDE_PX:g} each way, got {self.size_px}"
            )
        if not 0.0 < self.depth_m < WALL_DEPTH_M:
            raise ValueError(
                f"depth_m must lie between the camera and the scenery at {WALL_DEPTH_M:g} m, "
                f"got {self.depth_m!r}"
            )

    @property
    def size_m(self) -> tuple[float, float]:
        """Width and height at the start."""
        scale = self.depth_m / FOCAL_PX
        return self.size_px[0] * scale, self.size_px[1] * scale


@dataclass(frozen=True)
class Lighting:
    """Light from everywhere, a far lamp beside the camera, and a spotlight that wanders."""

    ambient: float = 0.40
    lamp: float = 0.60
    lamp_octaves: Terms = ()
    """Change of the lamp's brightness; 1 doubles it."""
    spot: float = 0.0
    spot_x_px: Terms = ()
    """Where the spotlight points on the scenery, from the middle of the image."""
    spot_y_px: Terms = ()


@dataclass(frozen=True)
class Shake:
    """How the camera turns on its tripod."""

    pan_rad: Terms = ()
    """Turn to the right."""
    tilt_rad: Terms = ()
    """Turn upwards."""


@dataclass(frozen=True)
class Clip:
    """A film with one target."""

    description: str
    target: Actor
    others: tuple[Actor, ...] = ()
    """Occluders, nearer than the target, or look-alikes behind it."""
    scenery: Scenery = "shelves"
    lighting: Lighting = Lighting()
    shake: Shake = Shake()
    exposure_frames: float = 0.0
    """How long the shutter is open: 0 freezes every motion, 1 blurs it all."""
    noise_levels: float = 1.5
    """Standard deviation of the sensor noise, in levels of 255."""
    frame_count: int = 90

    def __post_init__(self) -> None:
        require_at_least(self, 2, "frame_count")
        require_within(self, 0.0, 1.0, "exposure_frames")
        require_at_least(self, 0.0, "noise_levels")
