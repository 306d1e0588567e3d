"""The rendered benchmark: what is filmed for each of the eleven challenges.

Two clips for each challenge have that one alone, or hardly another; two more mix several. A clip
carries a tag where the benchmark's definition of it holds [OTB2015], which the tests measure where
it is a number. A reference scorer takes a box with x or y <= 0 for missing, so a target that leaves
does so to the right or downwards.
"""

from dataclasses import dataclass
from typing import Any

from sim.video.clip import Actor, Clip, Lighting, Moves, Shake, Swing, Terms, Trip, Wave


@dataclass(frozen=True)
class Recipe:
    """A sequence of the benchmark."""

    attributes: tuple[str, ...]
    """Tags of `experiments.video.sequences.ATTRIBUTES`."""
    clip: Clip


def _film(attributes: str, description: str, target: Actor, **rest: Any) -> Recipe:
    return Recipe(tuple(attributes.split()), Clip(description, target, **rest))


def _wave(peak: float, shortest: float, longest: float) -> Terms:
    return (Wave(peak, (shortest, longest)),)


def _swing(peak: float, shortest: float, longest: float) -> Terms:
    return (Swing(peak, (shortest, longest)),)


def _slow(peak: float) -> Terms:
    return _wave(peak, 40.0, 90.0)


def _pole(x_px: float, width_px: float, depth_m: float = 1.0) -> Actor:
    return Actor((width_px, 300), start_px=(x_px, 120), depth_m=depth_m, artwork="pole")


_X, _Y = _slow(50.0), _slow(30.0)

_LIGHT_AND_SIZE = {
    "Flicker": _film(
        "IV",
        "a failing lamp dims to an eighth and flares up again",
        Actor((64, 48), moves=Moves(_X, _Y)),
        lighting=Lighting(ambient=0.12, lamp=0.75, lamp_octaves=_wave(-3.0, 8, 40)),
    ),
    "Spotlight": _film(
        "IV",
        "a spotlight wanders over a dark wall, onto the target and off it",
        Actor((60, 50), moves=Moves(_X, _Y)),
        scenery="bricks",
        lighting=Lighting(
            ambient=0.10,
            lamp=0.10,
            spot=0.95,
            spot_x_px=_wave(130.0, 16, 40),
            spot_y_px=_wave(-70.0, 16, 40),
        ),
    ),
    "Approach": _film(
        "SV",
        "the target comes nearer until it is 2.6 times as large",
        Actor((46, 36), moves=Moves(_slow(25), _slow(15), _swing(1.4, 60, 110))),
    ),
    "Retreat": _film(
        "SV",
        "the target shrinks to a third and comes back",
        Actor((112, 84), depth_m=1.1, moves=Moves(_X, _slow(20), _swing(-1.55, 60, 110))),
        scenery="leaves",
    ),
    "Speck": _film(
        "LR",
        "a far label in a noisy image",
        Actor((20, 16), depth_m=2.5, moves=Moves(_slow(90), _slow(60))),
        scenery="bricks",
        noise_levels=3.0,
    ),
    "Distant": _film(
        "LR",
        "a small target between leaves of its own size turns a little",
        Actor((17, 19), depth_m=2.5, moves=Moves(_slow(70), _Y, _slow(0.2), _slow(0.3))),
        scenery="leaves",
    ),
}

_HIDING = {
    "Posts": _film(
        "OCC",
        "the target walks behind two poles, one wider than itself, to and fro",
        Actor((56, 46), start_px=(55, 120), moves=Moves(_swing(210, 50, 80), _Y)),
        others=(_pole(125, 40), _pole(215, 66, 1.1)),
    ),
    "PasserBy": _film(
        "OCC",
        "a larger poster passes in front of the target and comes back",
        Actor((58, 46), moves=Moves(_slow(20), _slow(15))),
        others=(
            Actor(
                (84, 110),
                start_px=(-60, 120),
                depth_m=1.0,
                moves=Moves((Trip(by=440, leave=8, back=48, ramp=34),)),
            ),
        ),
        scenery="bricks",
    ),
    "Exit": _film(
        "OV",
        "the target leaves to the right, stays away for half a second, and returns",
        Actor((60, 48), moves=Moves((Trip(by=240, leave=12, back=55, ramp=28), *_slow(15)), _Y)),
        scenery="leaves",
    ),
    "Dive": _film(
        "OV",
        "the target dives below the lower edge, then half below it",
        Actor(
            (62, 50),
            moves=Moves(
                _X,
                (
                    Trip(by=165, leave=10, back=40, ramp=20),
                    Trip(by=118, leave=68, back=84, ramp=15),
                ),
            ),
        ),
        frame_count=105,
    ),
    "Gallery": _film(
        "BC",
        "a wall of posters of the target's kind and size",
        Actor((60, 48), moves=Moves(_X, _Y)),
        scenery="gallery",
    ),
    "Twins": _film(
        "BC",
        "five look-alikes roam behind the target",
        Actor((60, 48), moves=Moves(_slow(80), _slow(40))),
        others=tuple(
            Actor(
                (60, 48),
                start_px=start,
                depth_m=1.7 + 0.1 * number,
                artwork="look-alike",
                moves=Moves(_slow(80), _slow(50)),
            )
            for number, start in enumerate(((60, 60), (260, 60), (60, 185), (260, 185), (160, 40)))
        ),
    ),
}

_SHAPE = {
    "Flag": _film(
        "DEF OPR",
        "a sheet waves and rolls up to a half cylinder",
        Actor(
            (92, 68),
            depth_m=0.7,
            shape="sheet",
            moves=Moves(
                _slow(40),
                _slow(20),
                yaw_rad=_wave(0.6, 30, 60),
                bend_rad=_wave(2.2, 25, 60),
                ripple=_wave(0.10, 15, 30),
            ),
        ),
        scenery="bricks",
    ),
    "Rubber": _film(
        "DEF",
        "a rubber sheet is pulled into an S within its plane",
        Actor(
            (76, 64),
            shape="sheet",
            moves=Moves(_X, _Y, sway=_wave(0.17, 14, 36), bend_rad=_wave(0.8, 20, 50)),
        ),
    ),
    "Carton": _film(
        "OPR",
        "a box turns so far that its side becomes as wide as its front",
        Actor(
            (70, 54),
            shape="carton",
            thickness=0.5,
            moves=Moves(_X, _slow(20), yaw_rad=_wave(1.0, 35, 80), pitch_rad=_wave(0.5, 35, 80)),
        ),
    ),
    "Door": _film(
        "OPR",
        "a panel swings until a third of its width is left",
        Actor((66, 62), moves=Moves(_slow(30), _slow(20), yaw_rad=_wave(1.2, 25, 60))),
        scenery="bricks",
    ),
    "Wheel": _film(
        "IPR",
        "the target turns upside down and back in the image plane",
        Actor((62, 50), moves=Moves(_X, _Y, roll_rad=_wave(3.1, 40, 90))),
        scenery="leaves",
    ),
    "Pendulum": _film(
        "IPR",
        "the target swings fast by more than a right angle",
        Actor((80, 38), moves=Moves(_X, _Y, roll_rad=_wave(-1.7, 16, 34))),
    ),
}

_HASTE_AND_MIXED = {
    "Streak": _film(
        "MB",
        "the target smears over a long exposure",
        Actor((64, 50), moves=Moves(_wave(80, 20, 34), _wave(45, 18, 30))),
        exposure_frames=0.9,
        scenery="bricks",
    ),
    "ShakyHands": _film(
        "MB",
        "the camera shakes, and everything smears",
        Actor((60, 48), moves=Moves(_slow(40), _slow(25))),
        shake=Shake(_wave(0.11, 10, 24), _wave(0.07, 10, 24)),
        exposure_frames=0.8,
    ),
    "Hummingbird": _film(
        "FM",
        "the target darts to and fro, each image sharp",
        Actor((56, 48), moves=Moves(_wave(105, 11, 20), _wave(55, 11, 20))),
        scenery="leaves",
    ),
    "Jolt": _film(
        "MB FM",
        "the camera is jolted by more than half the target's width in a frame",
        Actor((58, 50), moves=Moves(_slow(15), _slow(15))),
        scenery="bricks",
        shake=Shake(_wave(0.24, 8, 16), _wave(0.14, 8, 16)),
        exposure_frames=0.4,
    ),
    "Storm": _film(
        "IV SV OCC MB IPR",
        "light, size, turn and shake change together, and a pole stands in the way",
        Actor(
            (78, 60),
            start_px=(100, 120),
            depth_m=1.4,
            moves=Moves(
                _swing(130, 50, 80), _Y, _swing(-1.3, 60, 110), roll_rad=_wave(1.0, 30, 70)
            ),
        ),
        others=(_pole(190, 46),),
        lighting=Lighting(ambient=0.15, lamp=0.75, lamp_octaves=_wave(-2.0, 12, 40)),
        shake=Shake(_wave(0.06, 12, 28), _wave(0.04, 12, 28)),
        exposure_frames=0.7,
        scenery="bricks",
        frame_count=120,
    ),
    "Mayfly": _film(
        "FM IPR LR",
        "a tiny target that darts and turns",
        Actor(
            (21, 17),
            depth_m=2.5,
            moves=Moves(_wave(110, 12, 30), _wave(60, 12, 30), roll_rad=_wave(2.0, 20, 50)),
        ),
    ),
}

RECIPES: dict[str, Recipe] = _LIGHT_AND_SIZE | _HIDING | _SHAPE | _HASTE_AND_MIXED
"""Every sequence of the rendered benchmark, by name."""
