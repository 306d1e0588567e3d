import math
from dataclasses import dataclass

import pytest

from tracker.belt.prediction import make_predictor
from tracker.belt.registry import get_tracker_config
from tracker.checks import (
    require_choice,
    require_count,
    require_known,
    require_positive,
    require_share,
)
from tracker.peers.outside import get_box_finder


@dataclass(frozen=True)
class Settings:
    reach: float = 1.0
    mode: str = "near"


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_what_is_not_positive_is_refused(value):
    with pytest.raises(ValueError, match=r"^reach must be a positive number, got "):
        require_positive(Settings(value), "reach")
    require_positive(Settings(1e-9), "reach")


@pytest.mark.parametrize("value", [-0.1, 1.1, math.nan])
def test_what_is_no_share_is_refused(value):
    with pytest.raises(ValueError, match=r"^reach must be in \[0, 1\], got "):
        require_share(Settings(value), "reach")
    require_share(Settings(0.0), "reach")
    require_share(Settings(1.0), "reach")


def test_counts_have_a_least_value():
    require_count(Settings(2), "reach", least=2)
    with pytest.raises(ValueError, match=r"^reach must be 2 or greater, got 1$"):
        require_count(Settings(1), "reach", least=2)


def test_an_unknown_name_is_answered_with_the_valid_ones_and_the_nearest():
    names = {"first": 1, "second": 2}
    require_known("place", "first", names)
    with pytest.raises(
        ValueError,
        match=r"^place must be one of first, second; got 'secnd'; did you mean 'second'\?$",
    ):
        require_known("place", "secnd", names)
    with pytest.raises(ValueError, match=r"^place must be one of first, second; got 'xyz'$"):
        require_known("place", "xyz", list(names))
    with pytest.raises(ValueError, match=r"^mode must be one of near, far; got 3$"):
        require_choice(Settings(mode=3), "mode", ("near", "far"))


@pytest.mark.parametrize(
    ("lookup", "wrong", "meant"),
    [
        (get_tracker_config, "igfp", "igpf"),
        (get_box_finder, "kfc", "kcf"),
        (make_predictor, "kalmann", "kalman"),
    ],
)
def test_every_lookup_suggests(lookup, wrong, meant):
    with pytest.raises(ValueError, match=f"got '{wrong}'; did you mean '{meant}'"):
        lookup(wrong)
