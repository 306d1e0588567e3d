"""Artwork and scenery for the films, painted from random numbers."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np

from sim.textures import AMBER, INK, KRAFT, NAVY, PAPER, RED, TEAL, Canvas, Colour

_PAINTS: tuple[Colour, ...] = (KRAFT, NAVY, RED, AMBER, TEAL, (86, 60, 120), (92, 128, 64))
_WORDS = ("TEA", "SALT", "PEAR", "FIG", "PIE", "SAGE", "RIBS", "TART")
_TEXTURE_PX = 256
"""Length of a poster's longer side."""
_WALL_PX_PER_MM = 0.16
WALL_MM = (7600.0, 5800.0)
"""Size of the scenery."""


@dataclass(frozen=True)
class Style:
    """Colours that posters of one kind share."""

    paper: Colour
    band: Colour
    sign: Colour
    core: Colour

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Self:
        """Four different colours, light and dark ones among them."""
        numbers = rng.choice(np.arange(1, len(_PAINTS)), 2, replace=False)
        band, sign = (_PAINTS[int(k)] for k in numbers)
        paper = PAPER if rng.random() < 0.5 else KRAFT
        return cls(paper, band, sign, PAPER if paper is KRAFT else INK)


def poster(style: Style, size_mm: tuple[float, float], rng: np.random.Generator) -> np.ndarray:
    """(h, w, 3) uint8 label of a shop good; nothing on it repeats when it is turned."""
    scale = 100.0 / max(size_mm)
    width, height = size_mm[0] * scale, size_mm[1] * scale
    c = Canvas(width, height, _TEXTURE_PX / 100.0, style.paper)
    c.grain(4.0, seed=int(rng.integers(2**31)))
    edge = float(rng.uniform(0.30, 0.42))
    c.polygon([(0, 0), (edge * width, 0), ((edge - 0.12) * width, height), (0, height)], style.band)
    _paint_sign(c, style, edge, rng)
    dot = min(0.022 * width, 0.045 * height)
    c.text((edge + 0.06) * width, 0.08 * height, dot, str(rng.choice(_WORDS)), INK)
    left, top = (edge + rng.uniform(0.02, 0.10)) * width, 0.50 * height
    c.rectangle(left, top, 0.34 * width, 0.40 * height, (250, 250, 246))
    c.bars(left + 2, top + 2, 0.34 * width - 4, 0.2 * height, seed=int(rng.integers(2**31)))
    for row in range(2):
        c.rectangle(left + 2, (0.76 + 0.07 * row) * height, rng.uniform(8, 22), 1.6, INK)
    x, y, s = 0.89 * width, rng.uniform(0.42, 0.68) * height, 0.11 * min(width, height) + 3
    c.polygon([(x, y - s), (x + s, y + s), (x - s, y + s)], style.sign)
    _paint_frame(c, width, height)
    return c.to_uint8()


def _paint_sign(c: Canvas, style: Style, edge: float, rng: np.random.Generator) -> None:
    """A ring on the band."""
    radius = 0.36 * edge * c.width_mm
    x, y = 0.45 * edge * c.width_mm, rng.uniform(0.28, 0.72) * c.height_mm
    c.disc(x, y, radius, style.sign)
    c.disc(x, y, 0.5 * radius, style.core)
    turn = rng.uniform(0.0, 2.0 * np.pi)
    c.disc(x + 0.7 * radius * np.cos(turn), y + 0.7 * radius * np.sin(turn), 0.2 * radius, PAPER)


def _paint_frame(c: Canvas, width: float, height: float) -> None:
    """A dark edge, so that outlines show on any scenery."""
    for x, y in ((0, 0), (0, height - 1.2)):
        c.rectangle(x, y, width, 1.2, INK)
    for x, y in ((0, 0), (width - 1.2, 0)):
        c.rectangle(x, y, 1.2, height, INK)


def pole(style: Style, size_mm: tuple[float, float], rng: np.random.Generator) -> np.ndarray:
    """(h, w, 3) uint8 slanting stripes."""
    scale = 100.0 / max(size_mm)
    width, height = size_mm[0] * scale, size_mm[1] * scale
    c = Canvas(width, height, _TEXTURE_PX / 100.0, (112, 116, 112))
    pitch = float(rng.uniform(12.0, 18.0))
    for y in np.arange(0.0, height + 0.5 * width, pitch):
        stripe = [(0, y), (width, y - 0.5 * width), (width, y + 0.4 * pitch - 0.5 * width)]
        c.polygon([*stripe, (0, y + 0.4 * pitch)], style.band)
    c.grain(5.0, seed=int(rng.integers(2**31)))
    return c.to_uint8()


def _wall(colour: Colour) -> Canvas:
    return Canvas(*WALL_MM, _WALL_PX_PER_MM, colour)


def shelves(style: Style, rng: np.random.Generator) -> np.ndarray:
    """(h, w, 3) uint8 warehouse: boards full of boxes."""
    c = _wall((64, 66, 72))
    for top in np.arange(0.0, WALL_MM[1], 600.0):
        x = float(rng.uniform(0.0, 100.0))
        while x < WALL_MM[0] - 450.0:
            w, h = rng.uniform(160.0, 420.0), rng.uniform(200.0, 500.0)
            paint = np.array(_PAINTS[rng.integers(len(_PAINTS))]) * rng.uniform(0.45, 1.0)
            r, g, b = (int(v) for v in paint)
            c.rectangle(x, top + 540.0 - h, w, h, (r, g, b))
            if rng.random() < 0.6:
                label = 0.45 * w, 0.3 * h
                c.rectangle(x + 0.2 * w, top + 540.0 - 0.8 * h, *label, PAPER)
                c.rectangle(x + 0.25 * w, top + 540.0 - 0.72 * h, 0.3 * w, 0.08 * h, INK)
            x += w + float(rng.uniform(10.0, 90.0))
        c.rectangle(0, top + 540.0, WALL_MM[0], 60.0, (150, 150, 146))
    c.grain(5.0, seed=int(rng.integers(2**31)))
    return c.to_uint8()


def bricks(style: Style, rng: np.random.Generator) -> np.ndarray:
    """(h, w, 3) uint8 brick wall with some windows."""
    c = _wall((168, 160, 150))
    for row, y in enumerate(np.arange(0.0, WALL_MM[1], 130.0)):
        for x in np.arange(-150.0 * (row % 2), WALL_MM[0], 300.0):
            shade = rng.uniform(0.7, 1.1)
            colour = int(150 * shade), int(84 * shade), int(66 * shade)
            c.rectangle(x + 10, y + 10, 280.0, 110.0, colour)
    for x in np.arange(500.0, WALL_MM[0] - 900.0, 1400.0):
        for y in np.arange(400.0, WALL_MM[1] - 1000.0, 1500.0):
            left, top = x + rng.uniform(-200, 200), y + rng.uniform(-150, 150)
            c.rectangle(left, top, 560.0, 760.0, PAPER)
            for k in range(4):
                pane = left + 40 + 250 * (k % 2), top + 40 + 350 * (k // 2)
                c.rectangle(*pane, 230.0, 330.0, (58, 78, 98))
    c.grain(6.0, seed=int(rng.integers(2**31)))
    return c.to_uint8()


def leaves(style: Style, rng: np.random.Generator) -> np.ndarray:
    """(h, w, 3) uint8 hedge."""
    c = _wall((34, 52, 30))
    for _ in range(2600):
        x, y = rng.uniform(0, WALL_MM[0]), rng.uniform(0, WALL_MM[1])
        size, turn, shade = rng.uniform(60, 170), rng.uniform(0, 2 * np.pi), rng.uniform(0.5, 1.6)
        along = size * np.array([np.cos(turn), np.sin(turn)])
        across = 0.4 * np.array([-along[1], along[0]])
        points = np.add([x, y], [along, across, -along, -across])
        red = int(60 * shade * rng.uniform(0.8, 1.8))
        c.polygon([tuple(p) for p in points.tolist()], (red, int(98 * shade), 44))
    c.grain(6.0, seed=int(rng.integers(2**31)))
    return c.to_uint8()


def gallery(style: Style, rng: np.random.Generator) -> np.ndarray:
    """(h, w, 3) uint8 wall of posters in the style of the target."""
    c, size_mm = _wall((120, 116, 110)), (800.0, 640.0)
    size_px = round(size_mm[0] * c.px_per_mm), round(size_mm[1] * c.px_per_mm)
    for y in np.arange(60.0, WALL_MM[1] - 700.0, 720.0):
        for x in np.arange(60.0, WALL_MM[0] - 860.0, 880.0):
            picture = cv2.resize(poster(style, size_mm, rng), size_px, interpolation=cv2.INTER_AREA)
            row, column = round(y * c.px_per_mm), round(x * c.px_per_mm)
            c.pixels[row : row + size_px[1], column : column + size_px[0]] = picture
    c.grain(3.0, seed=int(rng.integers(2**31)))
    return c.to_uint8()


SCENERIES: dict[str, Callable[[Style, np.random.Generator], np.ndarray]] = {
    "shelves": shelves,
    "bricks": bricks,
    "leaves": leaves,
    "gallery": gallery,
}
