"""What the cell of an episode looks like, where its delays lie, and which world it is."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from sim.arm.embodiments import get_embodiment
from sim.belt.motions import MOTIONS, draw_profile
from sim.belt.objects import get_object
from sim.belt.scenario import Scenario, ScenarioRange
from sim.imaging.camera import get_view
from sim.imaging.degradations import NORMAL, get_condition

PHYSICS_HZ = 480


@dataclass(frozen=True)
class TaskConfig:
    """What the cell looks like and where its delays lie."""

    embodiment: str = "ur5-rg2"
    object: str = "box"
    camera: str = "far-side"
    condition: str = NORMAL
    motion: str = "constant"
    """How the belt or the turntable moves in episodes drawn from the environment's own state."""
    speed_mps: float = 0.25
    """At which speed it does."""
    scenarios: ScenarioRange = field(default_factory=ScenarioRange)
    camera_rate_hz: float = 30.0
    """Must divide the physics rate of 480 Hz."""
    delay_s: float = 0.066
    """From exposure until the image (and what is computed from it) can be used [s]."""
    gripper_delay_s: float = 0.05
    """From a new width command to the first finger motion [s]."""
    has_camera: bool = True
    """Without a camera nothing is rendered; for control arms that see no image."""
    observes_camera: bool = True
    """Whether images are among the observations; without, `ConveyorGrasp.frame` has the newest,
    and only what somebody looks at is rendered."""

    @property
    def carrier(self) -> str:
        """What carries the object: a name of CARRIERS."""
        return MOTIONS[self.motion].carrier

    def __post_init__(self) -> None:
        get_embodiment(self.embodiment)
        get_object(self.object)
        get_view(self.camera)
        get_condition(self.condition)
        draw_profile(self.motion, self.speed_mps, np.random.default_rng(0))
        steps = PHYSICS_HZ / self.camera_rate_hz
        if not (math.isfinite(steps) and steps >= 1.0 and abs(steps - round(steps)) < 1e-9):
            rates = [str(r) for r in (10, 12, 15, 20, 24, 30, 40, 48, 60, 80, 96, 120)]
            raise ValueError(
                f"camera_rate_hz must divide {PHYSICS_HZ} (as {', '.join(rates)} do), "
                f"got {self.camera_rate_hz!r}"
            )
        for name in ("delay_s", "gripper_delay_s"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0.0):
                raise ValueError(f"{name} must be 0 or greater, got {value!r}")


@dataclass(frozen=True, eq=False)
class Episode:
    """The world of the next reset, where it shall not be drawn from the environment's state."""

    scenario: Scenario
    sensor_rng: np.random.Generator
