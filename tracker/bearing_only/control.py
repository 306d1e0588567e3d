"""How to move: look at the target, keep the distance, move aside with the speed left over."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tracker.bearing_only.measurements import (
    BodyIncrement,
    MotionCommand,
    PinholeCamera,
    PoseBelief,
    TargetBelief,
)
from tracker.bearing_only.observability import gain_gradient
from tracker.checks import require_positive, require_share

Manoeuvre: TypeAlias = Literal["none", "random", "trace", "log-det"]
"""What is done with the speed that following leaves: nothing (pure following), a random direction
across the line of sight, or the gradient of a gain."""

_TIE_BREAK = 1e-6
"""Share of a random direction in the gradient's. With the covariance aligned to the line of sight
the lateral gradient is exactly zero, a saddle, and only noise would start the manoeuvre."""

_FORWARD, _ACROSS = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 1.0])
"""Along the body's x axis, and the rest."""


@dataclass(frozen=True)
class ControlConfig:
    """How the vehicle is steered."""

    manoeuvre: Manoeuvre = "log-det"
    v_max_mps: float = 2.5
    """V of [Wu2022] Eq. 14."""
    equilibrium_m: float = 10.0
    """D^eq of [Wu2022] Eq. 15: the distance to keep."""
    steepness_per_m: float = 0.5
    """Lambda of [Wu2022] Eq. 15, in (0, 1]; the text does not say which."""
    floor_share: float = 0.5
    """Following may take this share of the speed at most while the range is uncertain; 1 for no
    such floor, as in [Wu2022]. An overestimated range otherwise gives all speed to following, and
    nothing ever corrects it."""
    floor_ratio: float = 0.08
    """The range is uncertain while its standard deviation is above this share of itself."""

    def __post_init__(self) -> None:
        require_positive(self, "v_max_mps", "equilibrium_m", "steepness_per_m", "floor_ratio")
        require_share(self, "floor_share")


def aim(rays_b: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., 3) turn (roll, pitch, yaw) that brings (..., 3) unit rays onto the body's x axis.

    Source: [Wu2022] Eq. 13, of a ray that is normalised (the text takes the arcsine of a vector
    of any length) and with the arctangent of two arguments.
    """
    turn = np.zeros_like(rays_b)
    turn[..., 1] = -np.arcsin(np.minimum(np.maximum(rays_b[..., 2], -1.0), 1.0))
    turn[..., 2] = np.arctan2(rays_b[..., 1], rays_b[..., 0])
    return turn


def follow_speed(
    distance_m: NDArray[np.float64], v_max_mps: float, equilibrium_m: float, steepness_per_m: float
) -> NDArray[np.float64]:
    """(...,) speed along the body's x axis [m/s].

    Source: [Wu2022] Eq. 15; -V + 2 V / (1 + exp(lambda (D - d))) is V tanh(lambda (d - D) / 2).
    """
    return v_max_mps * np.tanh(0.5 * steepness_per_m * (distance_m - equilibrium_m))


def range_std(pose: PoseBelief, target: TargetBelief) -> tuple[NDArray[np.float64], ...]:
    """(...,) distance to the target and its standard deviation along the line of sight [m]."""
    offset = target.position_m - pose.position_m
    distance = length(offset)
    sight = offset / np.maximum(distance, 1e-9)[..., None]
    P = target.covariance[..., :3, :3]
    return distance, np.sqrt(np.einsum("...i,...ij,...j->...", sight, P, sight))


def follow(config: ControlConfig, pose: PoseBelief, target: TargetBelief) -> NDArray[np.float64]:
    """(...,) following speed at the estimated distance, held down while the range is uncertain."""
    distance, std = range_std(pose, target)
    speed = follow_speed(distance, config.v_max_mps, config.equilibrium_m, config.steepness_per_m)
    limit = np.where(std > config.floor_ratio * distance, config.floor_share, 1.0)
    if config.manoeuvre == "none":
        limit = np.ones_like(distance)
    return np.clip(speed, -limit * config.v_max_mps, limit * config.v_max_mps)


def manoeuvre_direction(
    kind: Manoeuvre,
    camera: PinholeCamera,
    pose: PoseBelief,
    target: TargetBelief,
    pixel_std_px: float,
    normal: NDArray[np.float64],
) -> NDArray[np.float64]:
    """(..., 3) unit vector in the body's frame; zero for pure following.

    Args:
        kind: What is done with the speed that following leaves.
        camera: Of the vehicle.
        pose: Of the vehicle.
        target: Predicted to the next image.
        pixel_std_px: Noise of the target's pixel.
        normal: (..., 3) random numbers: the random direction, or what breaks a tie.
    """
    across = _ACROSS * normal
    if kind == "none":
        return np.zeros_like(normal)
    if kind == "random":
        return unit(across)
    g = gain_gradient(kind, camera, pose, target, pixel_std_px)
    g = unit(np.einsum("...ji,...j->...i", pose.R_world_body, g))
    return unit(g + _TIE_BREAK * unit(across))


def command(
    config: ControlConfig,
    dt_s: float,
    follow_mps: NDArray[np.float64],
    direction: NDArray[np.float64],
    turn_rad: NDArray[np.float64],
) -> MotionCommand:
    """The motion of the next step.

    Source: [Wu2022] Eq. 14, u = v_f e_x + (V - |v_f|) g / |g| and dx = V dt u / |u|. The text has
    no norm bars in the first, no time step in either, and a second rotation, as R^(W->R)' takes
    u to the world and Eq. 2 rotates it again: here both parts are in the body's frame and stay
    there. Pure following moves by v_f dt; Eq. 14 would force it to the speed V, and it would
    chatter at the equilibrium.

    Args:
        config: Of the control.
        dt_s: Time step.
        follow_mps: (...,) following speed.
        direction: (..., 3) of the manoeuvre, in the body's frame; zero for pure following.
        turn_rad: (..., 3) of the aim.
    """
    forward = follow_mps[..., None] * _FORWARD
    aside = (config.v_max_mps - np.abs(follow_mps))[..., None] * direction
    if config.manoeuvre == "none":
        velocity = forward
    else:
        velocity = config.v_max_mps * unit(forward + aside)
    return MotionCommand(BodyIncrement(dt_s * velocity, turn_rad), follow_mps, aside)


def length(v: NDArray[np.float64]) -> NDArray[np.float64]:
    """(...,) of (..., 3) vectors."""
    return np.sqrt(np.einsum("...i,...i->...", v, v))


def unit(v: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., 3) vectors of length one; zero stays zero."""
    norm = length(v)[..., None]
    return v / (norm + (norm == 0.0))


@dataclass(frozen=True)
class DifferentialDrive:
    """What the wheels of a vehicle with a fixed camera allow: it cannot move aside, so it weaves.

    The paper's own robot was one [Wu2022, section 6.1.2]; it takes the conversion from a control
    law of formation driving that the text does not give. Here the heading leans from the target
    towards the wanted motion as far as the camera still sees the target, and the wheels drive
    forward or backward along it at the wanted speed: a saw-tooth that creeps aside, as one parks a
    car.
    """

    max_turn_rate_radps: float = 1.0
    lean_rad: float = 0.35
    """How far the heading may lean from the target; within half the camera's field of view."""

    turn_back_share: float = 0.1
    """The wheels change between forward and backward when the wanted motion along the body's axis
    is this share of the speed the other way; without such a gap they would chatter."""

    def __post_init__(self) -> None:
        require_positive(self, "max_turn_rate_radps", "lean_rad")
        require_share(self, "turn_back_share")


class WheelDrive:
    """Turns free motions into those of the wheels; remembers whether it drives backward."""

    def __init__(self, config: DifferentialDrive) -> None:
        self._config = config
        self._sense: NDArray[np.float64] | None = None

    def convert(
        self, wanted_mps: NDArray[np.float64], ray_b: NDArray[np.float64], dt_s: float
    ) -> BodyIncrement:
        """The increment for a wanted motion: forward or backward, and a turn in the plane.

        Args:
            wanted_mps: (..., 3) velocity in the body's frame; its vertical part is left out.
            ray_b: (..., 3) direction of the target in the body's frame.
            dt_s: Time step.
        """
        x, y = wanted_mps[..., 0], wanted_mps[..., 1]
        speed = np.hypot(x, y)
        sense = self._sense_of(x, speed)
        course = np.arctan2(sense * y, sense * x)
        bearing = np.arctan2(ray_b[..., 1], ray_b[..., 0])
        lean, most = self._config.lean_rad, self._config.max_turn_rate_radps * dt_s
        turn = np.clip(np.clip(course, bearing - lean, bearing + lean), -most, most)
        is_possible = np.cos(course - turn) > 0.0
        forward = np.where(is_possible, sense * speed, 0.0)
        zero = np.zeros_like(forward)
        return BodyIncrement(
            np.stack([dt_s * forward, zero, zero], axis=-1), np.stack([zero, zero, turn], axis=-1)
        )

    def _sense_of(self, x: NDArray[np.float64], speed: NDArray[np.float64]) -> NDArray[np.float64]:
        """(...,): 1 for forward, -1 for backward."""
        if self._sense is None:
            self._sense = np.where(x < 0.0, -1.0, 1.0)
        is_against = self._sense * x < -self._config.turn_back_share * speed
        self._sense = np.where(is_against, -self._sense, self._sense)
        return self._sense
