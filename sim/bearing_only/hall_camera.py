"""The flying camera: images of the hall from any pose, with the noise of a sensor."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from sim.bearing_only.scene import (
    CAMERA,
    FOCAL_PX,
    HEIGHT_PX,
    WIDTH_PX,
    FlightScene,
    FlightSceneConfig,
)
from sim.checks import require_at_least
from sim.imaging.camera import OffscreenRenderer
from sim.imaging.degradations import Condition
from sim.imaging.noise import SensorNoise

_REFERENCE_PX = 40
"""Radius of the target in its reference photograph."""


@dataclass(frozen=True)
class HallCameraConfig:
    """Hall and sensor."""

    scene: FlightSceneConfig = field(default_factory=FlightSceneConfig)
    noise_std: float = 2.0
    """Standard deviation of each pixel and colour, in grey levels of 255."""

    def __post_init__(self) -> None:
        require_at_least(self, 0.0, "noise_std")


class HallCamera:
    """Takes the images of one run; close it when done, as it holds an OpenGL context.

    Args:
        config: Hall and sensor.
        scene_rng: Draws the hall.
        noise_rng: Draws the noise, which does not depend on what is seen.
    """

    def __init__(
        self,
        config: HallCameraConfig,
        scene_rng: np.random.Generator,
        noise_rng: np.random.Generator,
    ) -> None:
        self.config = config
        self.scene = FlightScene(config.scene, scene_rng)
        condition = Condition(colour_noise_std=config.noise_std, depth_noise_std_m=0.0)
        self._noise = SensorNoise(condition, noise_rng)
        self._renderer = OffscreenRenderer(self.scene.model, WIDTH_PX, HEIGHT_PX)

    def photograph(
        self, position_m: np.ndarray, R_world_body: np.ndarray, target_m: np.ndarray
    ) -> np.ndarray:
        """(h, w, 3) uint8 RGB image; arguments as in `FlightScene.show`."""
        self.scene.show(position_m, R_world_body, target_m)
        rgb, _ = self._renderer.render(self.scene.model, self.scene.data, CAMERA)
        window = slice(0, HEIGHT_PX), slice(0, WIDTH_PX)
        return self._noise.draw().on(lambda _: (rgb, np.empty(0)), window)[0]

    def reference_photograph(self) -> np.ndarray:
        """(h, w, 3) uint8 RGB of the target alone, as a user would photograph it beforehand."""
        radius = self.config.scene.target_radius_m
        ahead = np.array([radius * FOCAL_PX / _REFERENCE_PX, 0.0, 0.0])
        image = self.photograph(np.zeros(3), np.eye(3), ahead)
        half = _REFERENCE_PX // 2
        rows, columns = HEIGHT_PX // 2, WIDTH_PX // 2
        return image[rows - half : rows + half, columns - half : columns + half]

    def close(self) -> None:
        """Frees the OpenGL context."""
        self._renderer.close()

    def __enter__(self) -> HallCamera:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
