"""Pictures for the scene's surfaces, painted in memory from shapes and fixed seeds.

Nothing here is stored as a file: the same code paints the same pixels everywhere.
"""

from dataclasses import dataclass, field
from functools import cache
from typing import Any

import cv2
import numpy as np
from dm_control import mjcf

Colour = tuple[int, int, int]

KRAFT: Colour = (193, 152, 104)
INK: Colour = (38, 36, 44)
PAPER: Colour = (240, 236, 224)
NAVY: Colour = (24, 62, 112)
RED: Colour = (196, 48, 38)
AMBER: Colour = (240, 168, 32)
TEAL: Colour = (24, 128, 120)

_GLYPHS = {  # 5 x 7 dots, one row a number, the leftmost dot the highest bit
    "A": (14, 17, 17, 31, 17, 17, 17),
    "B": (30, 17, 17, 30, 17, 17, 30),
    "E": (31, 16, 16, 30, 16, 16, 31),
    "F": (31, 16, 16, 30, 16, 16, 16),
    "G": (14, 17, 16, 23, 17, 17, 14),
    "I": (14, 4, 4, 4, 4, 4, 14),
    "L": (16, 16, 16, 16, 16, 16, 31),
    "N": (17, 17, 25, 21, 19, 17, 17),
    "P": (30, 17, 17, 30, 16, 16, 16),
    "R": (30, 17, 17, 30, 20, 18, 17),
    "S": (15, 16, 16, 14, 1, 1, 30),
    "T": (31, 4, 4, 4, 4, 4, 4),
}


@dataclass(frozen=True, eq=False)
class Canvas:
    """A picture measured in millimetres from its upper left corner; shapes are antialiased."""

    width_mm: float
    height_mm: float
    px_per_mm: float
    background: Colour
    pixels: np.ndarray = field(init=False)
    """(h, w, 3) float, 0 to 255."""

    def __post_init__(self) -> None:
        shape = (round(self.height_mm * self.px_per_mm), round(self.width_mm * self.px_per_mm), 3)
        object.__setattr__(self, "pixels", np.empty(shape))
        self.pixels[:] = self.background

    def rectangle(self, x: float, y: float, width: float, height: float, colour: Colour) -> None:
        """Fills the rectangle with its upper left corner at (x, y)."""
        self.polygon([(x, y), (x + width, y), (x + width, y + height), (x, y + height)], colour)

    def polygon(self, corners: list[tuple[float, float]], colour: Colour) -> None:
        """Fills a convex polygon, its corners clockwise on the picture."""
        xs, ys = zip(*corners, strict=True)
        window, gx, gy = self._window(min(xs), min(ys), max(xs), max(ys))
        inside = np.full(gx.shape, np.inf)
        for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True):
            length = np.hypot(x1 - x0, y1 - y0)
            depth = ((x1 - x0) * (gy - y0) - (y1 - y0) * (gx - x0)) / length
            inside = np.minimum(inside, depth)
        self._blend(window, inside, colour)

    def disc(self, x: float, y: float, radius: float, colour: Colour) -> None:
        """Fills a disc."""
        window, gx, gy = self._window(x - radius, y - radius, x + radius, y + radius)
        self._blend(window, radius - np.hypot(gx - x, gy - y), colour)

    def text(self, x: float, y: float, dot: float, words: str, colour: Colour) -> None:
        """Writes dot-matrix capitals from the upper left corner (x, y), one dot `dot` wide."""
        for index, letter in enumerate(words):
            for row, bits in enumerate(_GLYPHS[letter]):
                for column in range(5):
                    if bits >> (4 - column) & 1:
                        left = x + dot * (6 * index + column)
                        self.rectangle(left, y + dot * row, dot, dot, colour)

    def bars(self, x: float, y: float, width: float, height: float, seed: int) -> None:
        """Draws a bar code."""
        rng = np.random.default_rng(seed)
        left = x
        while left < x + width - 2.0:
            bar = float(rng.choice([0.8, 1.2, 2.0]))
            self.rectangle(left, y, bar, height, INK)
            left += bar + float(rng.choice([0.8, 1.2, 1.8]))

    def grain(self, amplitude: float, seed: int) -> None:
        """Adds the mottle of a real surface: fine noise and broader patches."""
        rng = np.random.default_rng(seed)
        height, width = self.pixels.shape[:2]
        for cell, share in ((1, 0.5), (8, 1.0)):
            coarse = rng.standard_normal((-(-height // cell), -(-width // cell)))
            patch = cv2.resize(coarse, (width, height), interpolation=cv2.INTER_LINEAR)
            self.pixels[:] += (share * amplitude * patch)[:, :, None]

    def to_uint8(self) -> np.ndarray:
        """(h, w, 3) uint8, read-only."""
        pixels = np.clip(np.round(self.pixels), 0, 255).astype(np.uint8)
        pixels.flags.writeable = False
        return pixels

    def _window(
        self, left: float, top: float, right: float, bottom: float
    ) -> tuple[tuple[slice, slice], np.ndarray, np.ndarray]:
        """Pixels that a shape may touch (none outside the picture), and their centres [mm]."""
        limits = zip(((top, bottom), (left, right)), self.pixels.shape, strict=False)
        rows, columns = (
            slice(
                min(max(0, int(low * self.px_per_mm) - 1), size),
                max(0, min(size, int(high * self.px_per_mm) + 2)),
            )
            for (low, high), size in limits
        )
        x, y = np.arange(columns.start, columns.stop), np.arange(rows.start, rows.stop)
        gx, gy = np.meshgrid((x + 0.5) / self.px_per_mm, (y + 0.5) / self.px_per_mm)
        return (rows, columns), gx, gy

    def _blend(self, window: tuple[slice, slice], depth_mm: np.ndarray, colour: Colour) -> None:
        cover = np.clip(0.5 + depth_mm * self.px_per_mm, 0.0, 1.0)[:, :, None]
        self.pixels[window] += cover * (np.array(colour, float) - self.pixels[window])


def apply(mjcf_root: Any, material: str, pixels: np.ndarray) -> None:
    """Gives the named material of a PyMJCF model the (h, w, 3) uint8 picture as its texture."""
    done, data = cv2.imencode(".png", pixels[:, :, ::-1])
    if not done:
        raise ValueError(f"pixels must be a (h, w, 3) uint8 picture, got {pixels.shape}")
    picture = mjcf.Asset(contents=data.tobytes(), extension=".png")
    texture = mjcf_root.asset.add("texture", name=material, type="2d", file=picture)
    mjcf_root.find("material", material).texture = texture


@cache
def belt_surface(size_px: int = 128) -> np.ndarray:
    """One period of a rubber belt: a fine weave with a faint line across."""
    c = Canvas(100.0, 100.0, size_px / 100.0, (58, 72, 74))
    c.grain(4.0, seed=21)
    weave = 4.0 * np.sin(2 * np.pi * np.arange(size_px) * 16 / size_px)
    c.pixels[:] += weave[:, None, None] + weave[None, :, None]
    c.rectangle(0, 0, 100, 4, (74, 90, 92))
    return c.to_uint8()


@cache
def concrete(size_px: int = 256) -> np.ndarray:
    """One square slab of floor with its joints."""
    c = Canvas(1000.0, 1000.0, size_px / 1000.0, (150, 151, 152))
    c.grain(4.0, seed=31)
    for x, y, width, height in ((0, 0, 1000, 8), (0, 0, 8, 1000)):
        c.rectangle(x, y, width, height, (118, 119, 122))
    return c.to_uint8()


@cache
def busy_print(size_px: int = 256) -> np.ndarray:
    """One period of a print of labels, discs and bars in the colours of the objects, 400 mm."""
    c = Canvas(400.0, 400.0, size_px / 400.0, (86, 98, 100))
    rng = np.random.default_rng(41)
    colours = (PAPER, RED, AMBER, TEAL, NAVY, INK, KRAFT)
    for place in range(36):  # a tile of a square grid each, so that the print is even
        x, y = 66.6 * (place % 6), 66.6 * (place // 6)
        first, second = (int(k) for k in rng.choice(len(colours), 2, replace=False))
        left, top = rng.uniform(2.0, 14.0, 2)
        width, height = rng.uniform(24.0, 48.0, 2)
        if place % 3 == 0:
            c.disc(x + 33.0, y + 33.0, 0.5 * width, colours[first])
            c.disc(x + 33.0, y + 33.0, 0.25 * width, colours[second])
        else:
            c.rectangle(x + left, y + top, width, height, colours[first])
            c.bars(x + left + 3.0, y + top + 4.0, width - 6.0, 0.5 * height, seed=place)
    return c.to_uint8()
