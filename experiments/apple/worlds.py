"""The worlds of the rendered experiments, each drawn from its class, aspect and seed.

Worlds of one seed share what they can: the same place, axis, leaves and light for all aspects and,
with and without leaves in front, for both classes of a calyx. So classes are compared in pairs.
"""

import math
from dataclasses import dataclass

import numpy as np

from experiments.seeding import Stream, generator
from sim.apple.fruit import Fruit, PlacedFruit
from sim.apple.leaves import leaves_behind, leaves_in_front
from sim.apple.world import Light, Orchard, OrchardConfig
from sim.geometry import look_at
from tracker.checks import require_known

CLASSES = {
    "visible": "calyx towards the camera: the axis 15 to 50 degrees from the approach",
    "hidden": "hanging: the axis within 25 degrees of the vertical, stem up",
    "visible-leaves": "as visible, with three leaves in front",
    "hidden-leaves": "as hidden, with three leaves in front",
}
ASPECTS = (0.85, 0.92, 0.95)
_BEHIND, _IN_FRONT = 12, 3
_FIRST_RANGE_M, _LAST_RANGE_M = 0.60, 0.22
_ARC_RAD = math.radians(25.0)
_AIM_RAD = math.radians(2.0)
VIEW_COUNT = 8


@dataclass(frozen=True)
class WorldId:
    """Names one world."""

    fruit_class: str
    aspect: float
    seed: int

    def __post_init__(self) -> None:
        require_known("class", self.fruit_class, CLASSES)
        if not 0.5 <= self.aspect < 1.0:
            raise ValueError(f"aspect must be from 0.5 to below 1, got {self.aspect!r}")
        if self.seed < 0:
            raise ValueError(f"seed must be 0 or greater, got {self.seed}")


@dataclass(frozen=True, eq=False)
class World:
    """What a world holds, and the approach of its camera."""

    id: WorldId
    config: OrchardConfig
    approach: tuple[np.ndarray, ...]
    """(4, 4) T_world_camera of each view: over an arc of 50 degrees from 0.60 m to 0.22 m."""

    @property
    def fruit(self) -> PlacedFruit:
        """The fruit that is asked for."""
        return self.config.fruit

    def build(self) -> Orchard:
        """Compiles the world; pictures have a stream of their own."""
        return Orchard(self.config, _stream(self.id.seed, "paint"))


def draw_world(world_id: WorldId) -> World:
    """The world of that name."""
    seed, is_hidden = world_id.seed, world_id.fruit_class.startswith("hidden")
    rng = _stream(seed, "place")
    centre = np.array([1.0, 0.0, 0.30]) + rng.uniform(-1.0, 1.0, 3) * [0.03, 0.04, 0.03]
    radius_m, side = rng.uniform(0.036, 0.044), rng.choice([-1.0, 1.0])
    forward = np.array([centre[0], centre[1], 0.0])
    frame = look_at(centre - 0.6 * forward / np.linalg.norm(forward), centre)[:3, :3]
    draw_axis = hanging_axis if is_hidden else facing_axis
    axis = draw_axis(_stream(seed, "axis"), frame)
    leaves = leaves_behind(_stream(seed, "leaves"), centre, frame, _BEHIND)
    if world_id.fruit_class.endswith("-leaves"):
        rng = _stream(seed, "leaves in front")
        leaves += leaves_in_front(rng, centre, frame, radius_m, _IN_FRONT)
    fruit = PlacedFruit(Fruit(radius_m=radius_m, aspect=world_id.aspect), centre, axis)
    config = OrchardConfig(fruit, leaves=leaves, light=draw_light(_stream(seed, "light"), frame))
    return World(world_id, config, _approach(centre, frame, side, _stream(seed, "aim")))


def hanging_axis(rng: np.random.Generator, frame: np.ndarray) -> np.ndarray:
    """(3,) axis within 25 degrees of the vertical, evenly over that cap."""
    del frame
    return _around(np.array([0.0, 0.0, 1.0]), _cap(rng, 0.0, math.radians(25.0)), rng)


def facing_axis(rng: np.random.Generator, frame: np.ndarray) -> np.ndarray:
    """(3,) axis 15 to 50 degrees from the direction of view: the calyx looks at the camera."""
    return _around(frame[:, 2], _cap(rng, math.radians(15.0), math.radians(50.0)), rng)


def draw_light(rng: np.random.Generator, frame: np.ndarray) -> Light:
    """A lamp from above on the camera's side, and sky."""
    into = frame @ np.array([rng.uniform(-0.7, 0.7), rng.uniform(0.1, 0.8), rng.uniform(0.5, 1.0)])
    direction = (float(into[0]), float(into[1]), float(into[2]))
    return Light(direction, lamp=rng.uniform(0.45, 0.75), sky=rng.uniform(0.30, 0.50))


def pointed(eye_m: np.ndarray, centre_m: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """(4, 4) pose of a camera at `eye_m` that looks at the fruit as well as an arm aims."""
    distance = float(np.linalg.norm(centre_m - eye_m))
    return look_at(eye_m, centre_m + distance * _AIM_RAD * rng.standard_normal(3))


def _approach(
    centre_m: np.ndarray, frame: np.ndarray, side: float, rng: np.random.Generator
) -> tuple[np.ndarray, ...]:
    poses: list[np.ndarray] = []
    ranges = np.linspace(_FIRST_RANGE_M, _LAST_RANGE_M, VIEW_COUNT)
    for range_m, turn in zip(ranges, np.linspace(-1, 1, VIEW_COUNT) * side * _ARC_RAD, strict=True):
        back = -math.cos(turn) * frame[:, 2] + math.sin(turn) * frame[:, 0]
        poses.append(pointed(centre_m + range_m * back, centre_m, rng))
    return tuple(poses)


def _cap(rng: np.random.Generator, low_rad: float, high_rad: float) -> float:
    """An angle from a pole, such that directions are even over the zone of the sphere."""
    return math.acos(rng.uniform(math.cos(high_rad), math.cos(low_rad)))


def _around(pole: np.ndarray, angle_rad: float, rng: np.random.Generator) -> np.ndarray:
    """(3,) a direction at this angle from the pole, to a random side."""
    first = np.cross(pole, np.eye(3)[np.argmin(np.abs(pole))])
    first /= np.linalg.norm(first)
    turn = rng.uniform(0.0, 2.0 * math.pi)
    sideways = math.cos(turn) * first + math.sin(turn) * np.cross(pole, first)
    return math.cos(angle_rad) * pole + math.sin(angle_rad) * sideways


def _stream(seed: int, place: str) -> np.random.Generator:
    return generator(seed, Stream.SCENE, f"apple {place}")
