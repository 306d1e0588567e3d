"""Conditions under which the camera looks at the belt: light, resolution and sensor noise.

Light is changed in the scene, not in the pixels; noise is added by the sensor, after the render.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np


@dataclass(frozen=True)
class Condition:
    """A named state of the light and of the sensor."""

    description: str
    light_scale: float = 1.0
    """Factor on the brightness of every light."""
    shadows: bool = False
    """Whether the key light casts shadows; doubles the cost of a frame."""
    width_px: int = 640
    height_px: int = 480
    colour_noise_std: float = 2.0
    """Standard deviation of the colour noise, in grey levels of 255."""
    depth_noise_std_m: float = 0.002

    def __post_init__(self) -> None:
        if not 0.0 <= self.light_scale <= 2.0:
            raise ValueError(f"light_scale must be from 0 to 2, got {self.light_scale!r}")
        if self.width_px < 16 or self.height_px < 16:
            raise ValueError(
                f"width_px and height_px must be 16 or more, got {self.width_px}x{self.height_px}"
            )
        if min(self.colour_noise_std, self.depth_noise_std_m) < 0.0:
            raise ValueError("colour_noise_std and depth_noise_std_m must be 0 or greater")


CONDITIONS: dict[str, Condition] = {
    "normal": Condition("bright even light, 640 x 480, 2 grey levels and 2 mm of noise"),
    "shadows": Condition("as normal, and the key light casts shadows", shadows=True),
    "dim": Condition("a quarter of the light, same noise", light_scale=0.25),
    "low-resolution": Condition("as normal at 320 x 240", width_px=320, height_px=240),
}


def get_condition(name: str) -> Condition:
    """The named condition; raises ValueError that lists the valid names."""
    if name not in CONDITIONS:
        raise ValueError(f"condition must be one of {', '.join(CONDITIONS)}; got {name!r}")
    return CONDITIONS[name]


class SensorNoise:
    """Gaussian noise on colour and depth.

    One noise picture a trial, larger than the image, is drawn from `rng`; each frame sees it
    through a window at a random place. That costs a tenth of fresh noise for every pixel, and the
    frames of a trial still look independent to anything that compares neighbours.
    """

    _MARGIN_PX = 64

    def __init__(self, condition: Condition, rng: np.random.Generator) -> None:
        self._rng = rng
        self._height, self._width = condition.height_px, condition.width_px
        size = (self._height + self._MARGIN_PX, self._width + self._MARGIN_PX)
        self._colour = self._depth = None
        if condition.colour_noise_std > 0.0:
            noise = rng.standard_normal((*size, 3), np.float32) * condition.colour_noise_std
            self._colour = np.rint(noise).astype(np.int16)
        if condition.depth_noise_std_m > 0.0:
            self._depth = rng.standard_normal(size, np.float32) * condition.depth_noise_std_m

    def _window(self, picture: np.ndarray) -> np.ndarray:
        row, column = self._rng.integers(0, self._MARGIN_PX, 2)
        return picture[row : row + self._height, column : column + self._width]

    def on(self, rgb: np.ndarray, depth_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The noisy image: (h, w, 3) uint8 colours, saturated, and (h, w) float32 depth [m]."""
        if self._colour is not None:
            rgb = cv2.add(rgb, self._window(self._colour), dtype=cv2.CV_8U)
        if self._depth is not None:
            depth_m = depth_m + self._window(self._depth)
        return rgb, depth_m
