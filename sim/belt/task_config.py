"""The settings of the conveyor task, and the world of its next episode."""

from dataclasses import dataclass, field, fields
from typing import Any, Self

import numpy as np

from sim.arm.embodiments import get_embodiment
from sim.belt.objects import get_object
from sim.belt.scenario import MOTIONS, Scenario, ScenarioRange
from sim.checks import look_up
from sim.imaging.camera import get_view
from sim.imaging.degradations import get_condition
from sim.world_config import WorldConfig


@dataclass(frozen=True)
class TaskConfig(WorldConfig):
    """A world, and what of it the environment draws by itself, renders and observes."""

    scenarios: ScenarioRange = field(default_factory=ScenarioRange)
    """Where episodes are drawn from that are not set by hand, at the world's motion and speed."""
    has_camera: bool = True
    """Without a camera nothing is rendered; for control arms that see no image."""
    observes_camera: bool = True
    """Whether images are among the observations; without, `ConveyorGrasp.image` has the newest,
    and only what somebody looks at is rendered."""

    @classmethod
    def of(cls, world: WorldConfig, **options: Any) -> Self:
        """Returns the task in that world; `options` are fields that `WorldConfig` lacks."""
        return cls(**{f.name: getattr(world, f.name) for f in fields(WorldConfig)}, **options)

    def __post_init__(self) -> None:
        super().__post_init__()
        get_embodiment(self.embodiment)
        get_object(self.object)
        get_view(self.camera)
        get_condition(self.condition)
        look_up("motion", self.motion, MOTIONS)

    @property
    def carrier(self) -> str:
        """What carries the object: a name of CARRIERS."""
        return MOTIONS[self.motion].carrier

    @property
    def as_compiled(self) -> Self:
        """The same model in its usual state; equal for tasks that can share one compiled model."""
        return type(self)(
            embodiment=self.embodiment,
            object=self.object,
            camera=self.camera,
            motion=next(name for name, m in MOTIONS.items() if m.carrier == self.carrier),
            has_camera=self.has_camera,
        )


@dataclass(frozen=True, eq=False)
class Episode:
    """The world of the next reset, where it shall not be drawn from the environment's state."""

    scenario: Scenario
    sensor_rng: np.random.Generator
