"""What is printed on the objects: pictures laid out as their meshes want them, in millimetres.

No face looks the same after a turn of less than a whole one: its print is what has a yaw.
"""

from functools import cache

import numpy as np

from sim.textures import AMBER, INK, KRAFT, NAVY, PAPER, RED, TEAL, Canvas


@cache
def carton() -> np.ndarray:
    """Unfolded print of the carton, laid out as the mesh `carton.obj` wants it, (640, 560, 3)."""
    c = Canvas(280.0, 320.0, 2.0, KRAFT)
    c.grain(5.0, seed=11)
    _paint_lid(c)
    for y in (80.0, 240.0):  # both sides
        c.rectangle(0, y + 58, 200, 10, NAVY)
        c.text(14, y + 16, 4.0, "BELT" if y == 80.0 else "GRASP", NAVY if y == 80.0 else RED)
        c.polygon([(168, y + 12), (182, y + 34), (154, y + 34)], INK)
        c.rectangle(163, y + 34, 10, 14, INK)
    c.rectangle(0, 195, 200, 10, (214, 182, 138))  # tape on the base
    c.rectangle(214, 14, 52, 40, PAPER)
    c.bars(219, 19, 42, 30, seed=5)
    c.disc(240, 120, 22, RED)
    c.disc(240, 120, 14, KRAFT)
    return c.to_uint8()


def _paint_lid(c: Canvas) -> None:
    """The top face: nothing on it repeats when it is turned by half a circle."""
    c.rectangle(0, 36, 200, 8, (214, 182, 138))
    c.rectangle(0, 0, 58, 80, NAVY)
    c.polygon([(58, 0), (74, 0), (58, 80)], NAVY)
    c.disc(28, 30, 19, AMBER)
    c.disc(28, 30, 9, NAVY)
    c.text(8, 60, 1.5, "GRASP", PAPER)
    c.rectangle(84, 10, 62, 42, PAPER)
    c.bars(90, 15, 50, 18, seed=3)
    c.rectangle(90, 38, 34, 3, INK)
    c.rectangle(90, 44, 46, 3, INK)
    c.polygon([(172, 6), (194, 44), (150, 44)], RED)
    c.polygon([(172, 16), (184, 38), (160, 38)], PAPER)
    c.rectangle(170, 22, 4, 12, INK)
    c.rectangle(150, 54, 44, 18, TEAL)
    c.text(152.5, 59.5, 0.95, "FRAGILE", PAPER)
    c.rectangle(96, 60, 38, 12, INK)


@cache
def small_carton() -> np.ndarray:
    """Unfolded print of the carton `small-carton.obj`, (480, 360, 3)."""
    c = Canvas(180.0, 240.0, 2.0, PAPER)
    c.grain(3.0, seed=12)
    c.rectangle(0, 0, 120, 60, TEAL)  # the lid
    c.polygon([(0, 0), (46, 0), (0, 46)], AMBER)
    c.disc(84, 26, 17, PAPER)
    c.disc(84, 26, 11, RED)
    c.text(8, 46, 1.2, "BELT", PAPER)
    c.bars(52, 48, 62, 9, seed=7)
    for y in (60.0, 180.0):  # both sides
        c.rectangle(0, y, 120, 16, TEAL)
        c.text(10, y + 28, 3.0, "GRASP", NAVY)
    c.rectangle(120, 0, 60, 20, AMBER)
    c.disc(150, 90, 16, RED)
    return c.to_uint8()


@cache
def plain_carton() -> np.ndarray:
    """Unfolded print of the carton `carton.obj`: white with a faint lettering, (640, 560, 3)."""
    faint = (218, 217, 214)
    c = Canvas(280.0, 320.0, 2.0, (228, 227, 224))
    c.grain(1.5, seed=13)
    c.rectangle(0, 37, 200, 6, (223, 222, 218))  # the seam of the lid
    c.text(16, 12, 2.6, "PLAIN", faint)
    c.disc(160, 56, 14, faint)
    for y in (80.0, 160.0, 240.0):
        c.text(60, y + 28, 3.0, "BELT", faint)
    return c.to_uint8()


@cache
def can() -> np.ndarray:
    """Lid, base and unrolled side of `can.obj`, 207 x 176 mm, (704, 829, 3)."""
    steel = (176, 178, 182)
    c = Canvas(66.0 * np.pi, 176.0, 4.0, RED)
    c.rectangle(0, 0, 132, 66, steel)
    c.disc(33, 33, 31, NAVY)  # the lid
    c.disc(33, 33, 27, PAPER)
    c.polygon([(33, 8), (52, 33), (33, 33)], RED)
    c.rectangle(13, 36, 40, 9, NAVY)
    c.text(15, 37.5, 0.9, "BELT", PAPER)
    c.disc(22, 24, 7, AMBER)
    c.bars(22, 47, 22, 8, seed=9)
    c.disc(99, 33, 31, (150, 152, 156))
    c.rectangle(0, 66 + 24, 66 * np.pi, 50, PAPER)
    for x in (14.0, 117.0):
        c.text(x, 66 + 36, 3.0, "GRASP", NAVY)
    c.rectangle(0, 66 + 84, 66 * np.pi, 4, AMBER)
    return c.to_uint8()


@cache
def flask() -> np.ndarray:
    """What `flask.obj` shows from above, 190 x 72 mm, (288, 760, 3)."""
    c = Canvas(190.0, 72.0, 4.0, (44, 92, 150))
    c.grain(3.0, seed=14)
    c.rectangle(143, 0, 25, 72, (60, 110, 168))  # the neck
    c.rectangle(168, 0, 22, 72, INK)
    c.rectangle(34, 8, 82, 56, PAPER)
    c.disc(52, 28, 13, RED)
    c.disc(52, 28, 6, PAPER)
    c.text(72, 14, 1.3, "BELT", NAVY)
    c.rectangle(72, 28, 36, 3, INK)
    c.bars(42, 47, 66, 11, seed=15)
    c.polygon([(18, 20), (30, 36), (18, 52)], AMBER)
    c.disc(127, 22, 6, PAPER)
    return c.to_uint8()
