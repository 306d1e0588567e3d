"""A vehicle with a camera flies after a target through a box of landmarks, at measurement level.

The world of [Wu2022] section 6: nothing is rendered; landmarks and target are points, and what the
camera gives are their pixels with noise. The vehicle obeys increments of position and rotation
with noise, and its odometry is what was commanded. Frames: world; body x forward, y left, z up.

All noise is drawn beforehand and by address, so that two controllers meet the same landmarks and
the same noise at the same iteration, wherever they fly. With a leading axis of the draws several
flights go on at once (without landmarks in view, whose number differs).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Literal, Self

import numpy as np
from scipy.spatial.transform import Rotation

from sim.checks import require_at_least, require_positive
from sim.geometry import R_BODY_CAMERA

DRAWS = ("landmarks", "odometry", "target-pixel", "landmark-pixels")
"""The noise sources, each with a generator of its own."""


@dataclass(frozen=True)
class FlightCamera:
    """A pinhole camera that looks along the body's x axis; [Wu2022] Table 1."""

    s_u_px: float = 320.0
    s_v_px: float = 320.0
    u0_px: float = 320.0
    v0_px: float = 240.0
    width_px: int = 640
    height_px: int = 480
    nearest_m: float = 0.3
    """Landmarks that are less deep in view are not found."""

    def see(self, points_b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns (..., 2) pixels of (..., 3) points in the body's frame, and which are in view."""
        c = points_b @ R_BODY_CAMERA
        depth = np.maximum(c[..., 2:], 1e-9)
        pixels = c[..., :2] / depth * [self.s_u_px, self.s_v_px] + [self.u0_px, self.v0_px]
        return pixels, self.contains(pixels) & (c[..., 2] > self.nearest_m)

    def contains(self, pixels: np.ndarray) -> np.ndarray:
        """Returns which of (..., 2) pixels are in the image."""
        inside = (pixels >= 0.0) & (pixels < [self.width_px, self.height_px])
        return np.all(inside, axis=-1)


@dataclass(frozen=True)
class TargetPath:
    """The way of the target: a straight line, or a circle in a horizontal plane."""

    kind: Literal["line", "circle"] = "circle"
    start_m: tuple[float, float, float] = (0.0, 15.0, 1.0)
    velocity_mps: tuple[float, float, float] = (-2.0, 0.0, 0.0)
    """Velocity at the start."""
    circle_length_m: float = 50.0
    """[Wu2022] section 6.2.2: start and end meet after 500 steps of 0.05 s at 2 m/s."""
    turns_left: bool = True

    def __post_init__(self) -> None:
        if self.kind not in ("line", "circle"):
            raise ValueError(f"kind must be line or circle; got {self.kind!r}")
        if not np.isfinite([*self.start_m, *self.velocity_mps]).all():
            raise ValueError(f"start_m and velocity_mps must be finite, got {self}")
        require_positive(self, "circle_length_m")

    def at(self, time_s: float) -> tuple[np.ndarray, np.ndarray]:
        """Returns position [m] and velocity [m/s], (3,) each."""
        start, velocity = np.array(self.start_m), np.array(self.velocity_mps)
        if self.kind == "line":
            return start + time_s * velocity, velocity
        sense = 1.0 if self.turns_left else -1.0
        radius = self.circle_length_m / (2.0 * math.pi)
        to_centre = sense * np.array([-velocity[1], velocity[0], 0.0])
        centre = start + radius * to_centre / np.hypot(velocity[0], velocity[1])
        angle = sense * np.hypot(velocity[0], velocity[1]) / radius * time_s
        turn = Rotation.from_rotvec([0.0, 0.0, angle]).as_matrix()
        rise = np.array([0.0, 0.0, velocity[2] * time_s])
        return centre + turn @ (start - centre) + rise, turn @ velocity


@dataclass(frozen=True)
class FlightConfig:
    """Everything that determines a world except the draws."""

    target: TargetPath = TargetPath()
    start_m: tuple[float, float, float] = (10.0, 15.0, 1.0)
    """Where the vehicle starts; [Wu2022] section 6.2.2."""
    yaw_rad: float = math.pi
    iteration_count: int = 500
    dt_s: float = 0.05
    landmark_count: int = 200
    landmark_low_m: tuple[float, float, float] = (-25.0, -25.0, -10.0)
    landmark_high_m: tuple[float, float, float] = (25.0, 25.0, 10.0)
    """The room of [Wu2022] section 6.1.1; landmarks are uniform in it."""
    camera: FlightCamera = FlightCamera()
    pixel_std_px: float = 3.0
    odometry_std_m: float = 0.01
    odometry_std_rad: float = math.radians(0.02)
    """[Wu2022] Table 1, per axis and step; the table has four positions where there are three."""
    is_planar: bool = False
    """Whether the vehicle is bound to its plane and turns about the vertical alone."""

    def __post_init__(self) -> None:
        require_at_least(self, 0, "landmark_count", "odometry_std_m", "odometry_std_rad")
        require_at_least(self, 1, "iteration_count")
        require_positive(self, "dt_s", "pixel_std_px")


@dataclass(frozen=True, eq=False)
class FlightDraws:
    """All that is random in a flight; standard normal but for the landmarks."""

    landmarks_m: np.ndarray
    """(..., n, 3) positions in the world."""
    odometry: np.ndarray
    """(..., k, 6) noise of displacement, then of rotation."""
    target_pixel: np.ndarray
    """(..., k, 2) noise of the target's pixel."""
    landmark_pixels: np.ndarray
    """(..., k, n, 2) noise of the landmarks' pixels."""

    @classmethod
    def of(cls, config: FlightConfig, rngs: Mapping[str, np.random.Generator]) -> Self:
        """Draws for one flight from one generator for each of `DRAWS`."""
        n, k = config.landmark_count, config.iteration_count
        low, high = config.landmark_low_m, config.landmark_high_m
        return cls(
            rngs["landmarks"].uniform(low, high, (n, 3)),
            rngs["odometry"].standard_normal((k, 6)),
            rngs["target-pixel"].standard_normal((k, 2)),
            rngs["landmark-pixels"].standard_normal((k, n, 2)),
        )

    @classmethod
    def stack(cls, draws: Sequence[Self]) -> Self:
        """Several flights as one with a leading axis."""
        return cls(*(np.stack([getattr(one, f.name) for one in draws]) for f in fields(cls)))


@dataclass(frozen=True, eq=False)
class Sight:
    """The camera's measurements at one instant."""

    landmark_ids: np.ndarray
    """(n,) numbers of the landmarks in view."""
    landmark_px: np.ndarray
    """(n, 2) their pixels."""
    target_px: np.ndarray
    """(..., 2) pixel of the target."""
    is_target_seen: np.ndarray
    """(...,) whether `target_px` is in view; elsewhere it means nothing."""


class Flight:
    """One flight, or as many at once as the draws have leading axes."""

    def __init__(self, config: FlightConfig, draws: FlightDraws) -> None:
        self.config, self._draws = config, draws
        self.landmarks_m = draws.landmarks_m
        """(..., n, 3) positions of the landmarks in the world."""
        leading = draws.odometry.shape[:-2]
        self.iteration = 0
        self.position_m = np.broadcast_to(np.array(config.start_m, float), (*leading, 3)).copy()
        yaw = Rotation.from_rotvec([0.0, 0.0, config.yaw_rad]).as_matrix()
        self.R_world_body = np.broadcast_to(yaw, (*leading, 3, 3)).copy()

    @property
    def target_m(self) -> np.ndarray:
        """(3,) position of the target now."""
        return self.config.target.at(self.iteration * self.config.dt_s)[0]

    @property
    def target_velocity_mps(self) -> np.ndarray:
        """(3,) velocity of the target now."""
        return self.config.target.at(self.iteration * self.config.dt_s)[1]

    def look(self) -> Sight:
        """Returns the camera's pixels now: landmarks for one flight, the target for all."""
        k, offset = self.iteration, self.target_m - self.position_m
        target_b = np.einsum("...ji,...j->...i", self.R_world_body, offset)
        target, is_seen = self._noisy(target_b, self._draws.target_pixel[..., k, :])
        if self.position_m.ndim > 1:
            return Sight(np.empty(0, int), np.empty((0, 2)), target, is_seen)
        landmarks_b = (self.landmarks_m - self.position_m) @ self.R_world_body
        pixels, in_view = self._noisy(landmarks_b, self._draws.landmark_pixels[k])
        return Sight(np.flatnonzero(in_view), pixels[in_view], target, is_seen)

    def _noisy(self, points_b: np.ndarray, noise: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(..., 2) noisy pixels, and which are in view both without the noise and with it."""
        pixels, is_seen = self.config.camera.see(points_b)
        pixels = pixels + self.config.pixel_std_px * noise
        return pixels, is_seen & self.config.camera.contains(pixels)

    def move(self, displacement_m: np.ndarray, rotation_rad: np.ndarray) -> None:
        """Carries out one increment with noise, and lets a time step pass.

        Args:
            displacement_m: (..., 3) in the body's frame.
            rotation_rad: (..., 3) roll, pitch and yaw about the body's axes.
        """
        noise = self._draws.odometry[..., self.iteration, :]
        dx = displacement_m + self.config.odometry_std_m * noise[..., :3]
        dphi = rotation_rad + self.config.odometry_std_rad * noise[..., 3:]
        if self.config.is_planar:
            dx, dphi = dx * [1.0, 1.0, 0.0], dphi * [0.0, 0.0, 1.0]
        self.position_m = self.position_m + np.einsum("...ij,...j->...i", self.R_world_body, dx)
        turn = Rotation.from_euler("ZYX", dphi[..., ::-1].reshape(-1, 3)).as_matrix()
        self.R_world_body = self.R_world_body @ turn.reshape(*dphi.shape[:-1], 3, 3)
        self.iteration += 1
