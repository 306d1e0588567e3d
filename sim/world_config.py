"""Everything that determines the world of an attempt, from the command line to the compiled model.

Light to import, so that the flags of a command line can be made from its fields.
"""

from dataclasses import dataclass

from sim.checks import require_within

PHYSICS_HZ = 480
"""Physics steps per simulated second."""


@dataclass(frozen=True)
class WorldConfig:
    """Robot, object, motion, camera and delays of an attempt to grasp a moving object."""

    speed_mps: float = 0.25
    """Belt speed [m/s]."""
    embodiment: str = "ur5-rg2"
    """Arm and gripper; `beltgrasp list` names them."""
    camera: str = "far-side"
    """Camera view; `beltgrasp list` names them."""
    condition: str = "normal"
    """Light, sensor, surroundings: `normal`, or degradations by level, as in `dark-3+blur-1`."""
    object: str = "box"
    """Object on the belt; `beltgrasp list` names them."""
    motion: str = "constant"
    """How the belt runs, or a turntable instead; `beltgrasp list` names them."""
    delay_s: float = 0.066
    """Age of an image when the tracker's answer to it is available [s]."""
    camera_rate_hz: float = 30.0
    """Exposures per second of simulated time [Hz]."""
    gripper_delay_s: float = 0.05
    """Time from the close command to the first finger motion [s]."""

    def __post_init__(self) -> None:
        # Names are checked where they are looked up: the registries take a second to import.
        object.__setattr__(self, "condition", _in_order(self.condition))
        require_within(self, 0.0, 3.0, "speed_mps")
        require_within(self, 0.0, 1.0, "delay_s", "gripper_delay_s")
        require_within(self, 1.0, 120.0, "camera_rate_hz")
        if not (PHYSICS_HZ / self.camera_rate_hz).is_integer():
            raise ValueError(
                f"camera_rate_hz must divide {PHYSICS_HZ} (as 10, 12, 15, 20, 24, 30, 40, 60 and "
                f"120 do), got {self.camera_rate_hz!r}"
            )


def _in_order(condition: str) -> str:
    """Returns the one name of a condition: its parts once each, sorted, and levels as numbers."""
    parts = (part.rpartition("-") for part in condition.split("+"))
    names = {
        f"{kind}-{int(level)}" if level.isdecimal() else kind + hyphen + level
        for kind, hyphen, level in parts
    }
    return "+".join(sorted(names))
