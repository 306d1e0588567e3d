"""The lookups and checks of the simulator's settings."""

import math
import re
from types import SimpleNamespace

import pytest

from sim.arm.embodiments import EMBODIMENTS, get_embodiment
from sim.belt.carriers import CARRIERS
from sim.belt.objects import OBJECTS, get_object
from sim.belt.scenario import MOTIONS, draw_profile
from sim.checks import look_up, require_at_least, require_positive, require_within
from sim.imaging.camera import CAMERAS, get_view
from sim.imaging.degradations import DEGRADATIONS, get_condition


def test_a_known_name_gives_its_entry():
    assert look_up("carrier", "belt", CARRIERS) is CARRIERS["belt"]


def test_an_unknown_name_is_answered_by_the_valid_ones_and_the_nearest():
    with pytest.raises(ValueError, match=r"^number must be one of one, two; got 'tow'; did you m"):
        look_up("number", "tow", {"one": 1, "two": 2})
    with pytest.raises(ValueError, match=r"got 'hundred'$"):
        look_up("number", "hundred", {"one": 1, "two": 2})


@pytest.mark.parametrize(
    ("get", "kind", "registry", "typed", "meant"),
    [
        (get_view, "camera", CAMERAS, "farside", "far-side"),
        (get_embodiment, "embodiment", EMBODIMENTS, "ur5-rg3", "ur5-rg2"),
        (get_object, "object", OBJECTS, "boxx", "box"),
        (lambda name: draw_profile(name, 0.2, None), "motion", MOTIONS, "turntabel", "turntable"),
        (lambda name: get_condition(f"{name}-2"), "degradation", DEGRADATIONS, "drak", "dark"),
    ],
)
def test_every_registry_suggests_a_name(get, kind, registry, typed, meant):
    message = f"{kind} must be one of {', '.join(registry)}; got '{typed}'; did you mean '{meant}'?"
    with pytest.raises(ValueError, match=re.escape(message)):
        get(typed)


@pytest.mark.parametrize("value", [math.nan, -0.1, 1.1, math.inf])
def test_numbers_outside_their_range_are_refused_by_name(value):
    with pytest.raises(ValueError, match=rf"share must be a number from 0 to 1, got {value}"):
        require_within(SimpleNamespace(share=value), 0.0, 1.0, "share")


@pytest.mark.parametrize("value", [math.nan, -1.0, math.inf])
def test_numbers_below_their_limit_are_refused_by_name(value):
    config = SimpleNamespace(good=0.0, bad=value)
    with pytest.raises(ValueError, match=rf"bad must be 0 or greater, got {value}"):
        require_at_least(config, 0.0, "good", "bad")
    with pytest.raises(ValueError, match=rf"bad must be a positive number, got {value}"):
        require_positive(config, "bad")
    with pytest.raises(ValueError, match=r"good must be a positive number, got 0\.0"):
        require_positive(config, "good")
